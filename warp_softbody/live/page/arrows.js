// Arrows of one kind: as many as are set, each with a foot, a vector and a colour.

const HEAD_SHARE = 0.35;

export class Arrows {
  constructor(size, { inFront = false, radius = 0.007 } = {}) {
    this.group = new THREE.Group();
    this.radius = radius * size;
    this.inFront = inFront;
    this.capacity = 0;
    this.up = new THREE.Vector3(0, 1, 0);
    this.way = new THREE.Vector3();
    this.foot = new THREE.Vector3();
    this.middle = new THREE.Vector3();
    this.turn = new THREE.Quaternion();
    this.scale = new THREE.Vector3();
    this.matrix = new THREE.Matrix4();
    this.color = new THREE.Color();
  }

  /** Room for a number of arrows, which `set` then places. */
  begin(count) {
    if (count > this.capacity) this.grow(Math.max(32, 2 * count));
    for (const mesh of this.group.children) mesh.count = count;
  }

  grow(capacity) {
    this.group.clear();
    this.capacity = capacity;
    const shapes = [
      new THREE.CylinderGeometry(1, 1, 1, 8),
      new THREE.ConeGeometry(1, 1, 12),
    ];
    for (const shape of shapes) {
      // drawn after the clear skin, whose colour would hide theirs
      const material = new THREE.MeshLambertMaterial({ transparent: true });
      material.depthTest = !this.inFront;
      const mesh = new THREE.InstancedMesh(shape, material, capacity);
      mesh.frustumCulled = false;
      mesh.renderOrder = this.inFront ? 4 : 2;
      this.group.add(mesh);
    }
  }

  set(index, x, y, z, vx, vy, vz, color) {
    const length = Math.hypot(vx, vy, vz);
    this.way.set(vx, vy, vz).divideScalar(length || 1);
    this.turn.setFromUnitVectors(this.up, this.way);
    const head = Math.min(HEAD_SHARE * length, 7 * this.radius);
    this.color.set(color);
    this.part(0, index, x, y, z, 0.5 * (length - head), length - head, this.radius);
    this.part(1, index, x, y, z, length - 0.5 * head, head, 2.4 * this.radius);
  }

  part(kind, index, x, y, z, along, length, radius) {
    const mesh = this.group.children[kind];
    this.middle.copy(this.way).multiplyScalar(along).add(this.foot.set(x, y, z));
    this.scale.set(radius, length, radius);
    mesh.setMatrixAt(index, this.matrix.compose(this.middle, this.turn, this.scale));
    mesh.setColorAt(index, this.color);
  }

  end() {
    for (const mesh of this.group.children) {
      mesh.instanceMatrix.needsUpdate = true;
      if (mesh.instanceColor) mesh.instanceColor.needsUpdate = true;
    }
  }
}
