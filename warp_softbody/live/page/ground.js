// The ground: tiles on a plane, or the triangles of an uneven one.

import { COLORS } from "./palette.js";

const ROUND = [1, 2, 5];
const REACH = 16;
/** Degrees between triangles of an uneven ground from which their edge is drawn. */
const LEAST_ANGLE = 8;
const CORNERS = [[0, 0], [1, 0], [1, 1], [0, 0], [1, 1], [0, 1]];

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
    if (!ground) return;
    const made = ground.vertices ? unevenGround(ground) : tiledGround(ground, size);
    this.shadow = made.userData.shadow ?? null;
    this.group.add(made);
  }

  moveTo(center) {
    if (!this.shadow) return;
    const height = this.shadow.position.z;
    this.shadow.parent.worldToLocal(this.shadow.position.copy(center)).setZ(height);
  }
}

function unevenGround(ground) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(ground.vertices), 3));
  geometry.setIndex(ground.faces);
  geometry.computeVertexNormals();
  const material = new THREE.MeshLambertMaterial({ color: COLORS.uneven, flatShading: true });
  material.side = THREE.DoubleSide;
  const mesh = new THREE.Mesh(geometry, material);
  mesh.receiveShadow = true;
  const group = new THREE.Group();
  const edges = new THREE.EdgesGeometry(geometry, LEAST_ANGLE);
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
  group.add(new THREE.Mesh(tileGeometry(tile, half), tiles));
  const shade = new THREE.ShadowMaterial({ color: COLORS.shadow, opacity: 0.28 });
  const shadow = new THREE.Mesh(new THREE.PlaneGeometry(4 * size, 4 * size), shade);
  shadow.position.z = 1e-3 * size;
  shadow.receiveShadow = true;
  group.add(shadow);
  const normal = new THREE.Vector3(...ground.normal);
  group.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), normal);
  group.position.copy(normal).multiplyScalar(ground.offset - 2e-3 * size);
  group.userData.shadow = shadow;
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
