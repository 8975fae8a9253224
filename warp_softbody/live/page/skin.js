// The skins of the bodies: corners that follow the shown points, with normals of their own.

const CLEAR = 0.62;

export class Skin {
  constructor(outline) {
    this.group = new THREE.Group();
    this.parts = outline.bodies.map((body) => this.makePart(body));
  }

  makePart(body) {
    const geometry = new THREE.BufferGeometry();
    const count = body.corners.length;
    for (const name of ["position", "normal"]) {
      const attribute = new THREE.BufferAttribute(new Float32Array(3 * count), 3);
      attribute.setUsage(THREE.DynamicDrawUsage);
      geometry.setAttribute(name, attribute);
    }
    geometry.setIndex(body.faces);
    const color = new THREE.Color(...body.color);
    const material = new THREE.MeshLambertMaterial({ color });
    const mesh = new THREE.Mesh(geometry, material);
    mesh.castShadow = true;
    mesh.frustumCulled = false;
    mesh.renderOrder = 1;
    this.group.add(mesh);
    return { mesh, geometry, material, corners: body.corners, faces: body.faces };
  }

  /** Whether muscles inside are to be seen. */
  setClear(clear) {
    for (const { material } of this.parts) {
      material.transparent = clear;
      material.opacity = clear ? CLEAR : 1;
      material.depthWrite = !clear;
      material.needsUpdate = true;
    }
  }

  show(moment) {
    const { cells, scale, origin } = moment;
    for (const { geometry, corners } of this.parts) {
      const position = geometry.attributes.position;
      const places = position.array;
      for (let corner = 0; corner < corners.length; corner++) {
        const from = 3 * corners[corner];
        for (let axis = 0; axis < 3; axis++) {
          places[3 * corner + axis] = origin[axis] + scale * cells[from + axis];
        }
      }
      position.needsUpdate = true;
      geometry.computeVertexNormals();
    }
  }

  /** Row of the shown point nearest to where a ray meets a skin, and the place; null if none. */
  pick(raycaster) {
    for (const { geometry } of this.parts) geometry.computeBoundingSphere();
    const [hit] = raycaster.intersectObjects(this.parts.map((part) => part.mesh));
    if (!hit) return null;
    const part = this.parts.find((candidate) => candidate.mesh === hit.object);
    const place = part.geometry.attributes.position;
    const corner = new THREE.Vector3();
    let nearest = null;
    for (const index of [hit.face.a, hit.face.b, hit.face.c]) {
      const distance = corner.fromBufferAttribute(place, index).distanceTo(hit.point);
      if (!nearest || distance < nearest.distance) nearest = { index, distance };
    }
    const row = part.corners[nearest.index];
    return { row, place: corner.fromBufferAttribute(place, nearest.index).clone() };
  }
}
