// The picture of a scene: bodies, muscles, ground and overlays, moment by moment.

import { Fibers } from "./fibers.js";
import { GroundView } from "./ground.js";
import { Overlays } from "./overlays.js";
import { Skin } from "./skin.js";
import { Stage3D } from "./stage3d.js";
import { vectorOf } from "./wire.js";

/** Of the way to the body, that the camera goes with each moment; all of it after a jump. */
const CATCH_UP = 0.2;
const JUMP = 0.15;

export class Viewer {
  constructor(container, outline) {
    this.outline = outline;
    const low = new THREE.Vector3(...outline.low);
    const high = new THREE.Vector3(...outline.high);
    this.size = low.distanceTo(high) || 1;
    this.stage = new Stage3D(container, this.size);
    this.skin = new Skin(outline);
    this.fibers = new Fibers(outline, this.size);
    this.overlays = new Overlays(outline, this.size);
    this.ground = new GroundView(outline.ground, this.size);
    this.stage.scene.add(this.ground.group, this.fibers.mesh, this.skin.group, this.overlays.group);
    this.middle = low.add(high).multiplyScalar(0.5);
    this.follows = true;
    this.offset = null;
    this.center = new THREE.Vector3();
    this.change = new THREE.Vector3();
    this.moment = null;
    this.stage.controls.addEventListener("end", () => this.keepOffset());
    this.stage.lookAt(this.middle, this.size);
    this.setLayer("muscles", outline.segmentCount > 0);
  }

  /** Stand where the body, where it is now, is seen whole. */
  home() {
    const there = this.offset ? this.change.copy(this.center).add(this.offset) : this.middle;
    this.stage.lookAt(there, this.size);
    this.stage.invalidate();
  }

  setLayer(name, on) {
    if (name === "muscles") {
      this.fibers.mesh.visible = on;
      this.skin.setClear(on);
    } else if (name === "follow") {
      this.follows = on;
      this.keepOffset();
    } else if (name === "friction") {
      this.ground.setFriction(on);
    } else {
      this.overlays.setLayer(name, on);
    }
    if (this.moment) this.show(this.moment);
  }

  show(moment) {
    const passed = this.moment ? moment.time - this.moment.time : 0;
    this.moment = moment;
    this.skin.show(moment);
    if (this.fibers.mesh.visible) this.fibers.show(moment);
    this.overlays.show(moment);
    if (vectorOf(this.outline, moment, "com", this.center)) {
      this.follow(passed < 0 || passed > JUMP ? 1 : CATCH_UP);
    }
    this.stage.invalidate();
  }

  /** Where the user's camera looks, seen from the centre of mass. */
  keepOffset() {
    if (this.moment) this.offset = this.stage.controls.target.clone().sub(this.center);
  }

  /** Let camera and target catch up with the centre of mass by a share of the way. */
  follow(share) {
    this.ground.moveTo(this.center);
    this.offset ??= this.middle.clone().sub(this.center);
    if (!this.follows) return;
    this.change.copy(this.center).add(this.offset).sub(this.stage.controls.target);
    this.stage.moveBy(this.change.multiplyScalar(share));
  }
}
