// The ground: tiles on a plane, or the triangles of an uneven one.

import { COLORS, frictionTint } from "./palette.js";

const ROUND = [1, 2, 5];
const REACH = 16;
/** Degrees between triangles of an uneven ground from which their edge is drawn. */
const LEAST_ANGLE = 8;
const CORNERS = [[0, 0], [1, 0], [1, 1], [0, 0], [1, 1], [0, 1]];
const TRIANGLE = 3;

/** A round length, m, near half of a size. */
export function tileLength(size) {
  const power = 10 ** Math.floor(Math.log10(size / 2));
  return ROUND.map((factor) => factor * power).filter((length) => length <= size / 2).pop();
}

/** What is seen of a ground; the square that takes the shadow is moved below the body. */
export class GroundView {
  constructor(ground, size) {
    this.group = new THREE.Group();
    this.shadow = null;
    this.colors = null;
    if (!ground) return;
    const made = ground.vertices ? unevenGround(ground) : tiledGround(ground, size);
    const { shadow, mesh, corners } = made.userData;
    this.shadow = shadow ?? null;
    this.group.add(made);
    if (!ground.friction) return;
    this.geometry = mesh.geometry;
    const plain = this.geometry.getAttribute("color");
    made.updateMatrix();
    this.colors = { plain, tinted: tinted(mesh, made.matrix, corners, ground.friction) };
  }

  /** Whether the ground has other colours where its friction is another. */
  setFriction(on) {
    if (this.colors) this.geometry.setAttribute("color", this.colors[on ? "tinted" : "plain"]);
  }

  moveTo(center) {
    if (!this.shadow) return;
    const height = this.shadow.position.z;
    this.shadow.parent.worldToLocal(this.shadow.position.copy(center)).setZ(height);
  }
}

/** Factor on the friction at a place, m: that of its cell, and beyond all cells of the outermost. */
function factorAt(map, x, y) {
  const cell = (place, axis, count) => {
    const found = Math.floor((place - map.origin[axis]) / map.spacing[axis]);
    return Math.min(count - 1, Math.max(0, found));
  };
  const rows = map.factors.length / map.columns;
  return map.factors[cell(x, 0, rows) * map.columns + cell(y, 1, map.columns)];
}

/** Colours of a mesh by the friction at the middle of every so many corners, turned by a matrix. */
function tinted(mesh, matrix, corners, map) {
  const places = mesh.geometry.getAttribute("position");
  const colors = mesh.geometry.getAttribute("color").clone();
  const corner = new THREE.Vector3();
  const middle = new THREE.Vector3();
  for (let start = 0; start < places.count; start += corners) {
    middle.set(0, 0, 0);
    for (let i = start; i < start + corners; i++) middle.add(corner.fromBufferAttribute(places, i));
    middle.divideScalar(corners).applyMatrix4(matrix);
    const tint = frictionTint(factorAt(map, middle.x, middle.y));
    for (let i = start; i < start + corners; i++) {
      colors.setXYZ(i, tint[0] * colors.getX(i), tint[1] * colors.getY(i), tint[2] * colors.getZ(i));
    }
  }
  return colors;
}

function unevenGround(ground) {
  const shared = new THREE.BufferGeometry();
  shared.setAttribute("position", new THREE.BufferAttribute(new Float32Array(ground.vertices), 3));
  shared.setIndex(ground.faces);
  // faces have colours of their own
  const geometry = shared.toNonIndexed();
  geometry.computeVertexNormals();
  const white = new Float32Array(3 * ground.faces.length).fill(1);
  geometry.setAttribute("color", new THREE.BufferAttribute(white, 3));
  const material = new THREE.MeshLambertMaterial({ color: COLORS.uneven, flatShading: true });
  material.side = THREE.DoubleSide;
  material.vertexColors = true;
  const mesh = new THREE.Mesh(geometry, material);
  mesh.receiveShadow = true;
  const group = new THREE.Group();
  group.userData = { mesh, corners: TRIANGLE };
  const edges = new THREE.EdgesGeometry(shared, LEAST_ANGLE);
  const lines = new THREE.LineBasicMaterial({ color: COLORS.edge });
  group.add(mesh, new THREE.LineSegments(edges, lines));
  return group;
}

/** Tiles of two shades, which light does not change, and a square that takes the shadow. */
function tiledGround(ground, size) {
  const tile = tileLength(size);
  const half = Math.ceil((REACH * size) / tile);
  const group = new THREE.Group();
  const tiles = new THREE.MeshBasicMaterial({ vertexColors: true });
  const mesh = new THREE.Mesh(tileGeometry(tile, half), tiles);
  group.add(mesh);
  const shade = new THREE.ShadowMaterial({ color: COLORS.shadow, opacity: 0.28 });
  const shadow = new THREE.Mesh(new THREE.PlaneGeometry(4 * size, 4 * size), shade);
  shadow.position.z = 1e-3 * size;
  shadow.receiveShadow = true;
  group.add(shadow);
  const normal = new THREE.Vector3(...ground.normal);
  group.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), normal);
  group.position.copy(normal).multiplyScalar(ground.offset - 2e-3 * size);
  group.userData = { shadow, mesh, corners: CORNERS.length };
  return group;
}

/** Tiles of a length about the origin, `half` of them to each side, darker every second one. */
function tileGeometry(tile, half) {
  const places = [];
  const colors = [];
  const shades = [COLORS.tileLight, COLORS.tileDark].map((name) => new THREE.Color(name).toArray());
  for (let i = -half; i < half; i++) {
    for (let j = -half; j < half; j++) {
      for (const [u, v] of CORNERS) {
        places.push(tile * (i + u), tile * (j + v), 0);
        colors.push(...shades[(i + j) & 1]);
      }
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(places, 3));
  geometry.setAttribute("color", new THREE.Float32BufferAttribute(colors, 3));
  return geometry;
}
