// Muscle segments as rods, coloured by how far they contract.

import { muscleColor } from "./palette.js";

const RADIUS = 0.011;

export class Fibers {
  constructor(outline, size) {
    const count = outline.segmentCount;
    this.outline = outline;
    this.radius = RADIUS * size;
    const rod = new THREE.CylinderGeometry(1, 1, 1, 7, 1, false);
    // drawn after the clear skin, whose colour would hide theirs
    const material = new THREE.MeshLambertMaterial({ transparent: true });
    this.mesh = new THREE.InstancedMesh(rod, material, Math.max(1, count));
    this.mesh.count = count;
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 2;
    this.from = new THREE.Vector3();
    this.to = new THREE.Vector3();
    this.along = new THREE.Vector3();
    this.up = new THREE.Vector3(0, 1, 0);
    this.turn = new THREE.Quaternion();
    this.scale = new THREE.Vector3();
    this.matrix = new THREE.Matrix4();
    this.color = new THREE.Color();
  }

  show(moment) {
    const { segments, points, segmentCount } = this.outline;
    for (let segment = 0; segment < segmentCount; segment++) {
      this.place(moment, points + segments[2 * segment], this.from);
      this.place(moment, points + segments[2 * segment + 1], this.to);
      this.along.subVectors(this.to, this.from);
      const length = this.along.length();
      this.turn.setFromUnitVectors(this.up, this.along.divideScalar(length || 1));
      // a rod that contracts becomes thicker, as a muscle does
      const contraction = moment.contraction[segment] / 510;
      const radius = this.radius * (1 + contraction);
      this.scale.set(radius, length, radius);
      this.matrix.compose(this.from.add(this.to).multiplyScalar(0.5), this.turn, this.scale);
      this.mesh.setMatrixAt(segment, this.matrix);
      this.mesh.setColorAt(segment, muscleColor(contraction, this.color));
    }
    this.mesh.instanceMatrix.needsUpdate = true;
    if (this.mesh.instanceColor) this.mesh.instanceColor.needsUpdate = true;
  }

  place(moment, row, out) {
    const { cells, scale, origin } = moment;
    const at = (axis) => origin[axis] + scale * cells[3 * row + axis];
    out.set(at(0), at(1), at(2));
  }
}
