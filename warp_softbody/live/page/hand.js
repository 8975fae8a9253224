// The mouse or a finger takes hold of a point of the skin and pulls it.

export class Hand {
  constructor(viewer, commands) {
    this.viewer = viewer;
    this.commands = commands;
    this.allowed = false;
    this.held = null;
    this.ray = new THREE.Raycaster();
    this.pointer = new THREE.Vector2();
    this.plane = new THREE.Plane();
    this.place = new THREE.Vector3();
    this.way = new THREE.Vector3();
    this.canvas = viewer.stage.renderer.domElement;
    this.canvas.classList.add("grabbable");
    // before the camera's own listeners, which then see that they are off
    const early = { capture: true };
    this.canvas.addEventListener("pointerdown", (event) => this.grab(event), early);
    this.canvas.addEventListener("pointermove", (event) => this.move(event), early);
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      this.canvas.addEventListener(end, () => this.release(), early);
    }
  }

  aim(event) {
    const box = this.canvas.getBoundingClientRect();
    const x = (2 * (event.clientX - box.left)) / box.width - 1;
    const y = 1 - (2 * (event.clientY - box.top)) / box.height;
    this.ray.setFromCamera(this.pointer.set(x, y), this.viewer.stage.camera);
  }

  grab(event) {
    if (!this.allowed || event.button !== 0 || event.shiftKey || !this.viewer.moment) return;
    this.aim(event);
    const hit = this.viewer.skin.pick(this.ray);
    if (!hit) return;
    this.held = event.pointerId;
    this.viewer.stage.controls.enabled = false;
    this.canvas.setPointerCapture(event.pointerId);
    this.viewer.stage.camera.getWorldDirection(this.way);
    this.plane.setFromNormalAndCoplanarPoint(this.way, hit.place);
    this.commands.send({ do: "grab", point: hit.row, to: hit.place.toArray() });
  }

  move(event) {
    if (this.held !== event.pointerId) return;
    this.aim(event);
    if (!this.ray.ray.intersectPlane(this.plane, this.place)) return;
    this.commands.send({ do: "drag", to: this.place.toArray() });
  }

  release() {
    if (this.held === null) return;
    this.held = null;
    this.viewer.stage.controls.enabled = true;
    this.commands.send({ do: "release" });
  }
}
