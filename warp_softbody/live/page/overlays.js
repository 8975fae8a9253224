// What is drawn over the bodies: contacts, plan, centre of mass, base, capture point, the hand.

import { Arrows } from "./arrows.js";
import { hull } from "./hull.js";
import { COLORS, MODE_COLORS } from "./palette.js";
import { vectorOf } from "./wire.js";

const ON_GROUND = 4;
const WEIGHT_LENGTH = 0.45;

export class Overlays {
  constructor(outline, size) {
    this.outline = outline;
    this.size = size;
    this.perNewton = outline.weight ? (WEIGHT_LENGTH * size) / outline.weight : 0;
    this.normal = new THREE.Vector3(...(outline.ground?.normal ?? [0, 0, 1]));
    this.contacts = new Arrows(size, { radius: 0.005 });
    this.plan = new Arrows(size, { radius: 0.008 });
    this.hand = new Arrows(size, { inFront: true, radius: 0.012 });
    this.center = marker(COLORS.center, 0.022 * size);
    this.plumb = line(COLORS.center, 2);
    this.base = new BaseOfSupport(size, this.normal);
    this.capture = marker(COLORS.capture, 0.02 * size);
    this.vector = new THREE.Vector3();
    this.force = new THREE.Vector3();
    const layers = {
      contacts: [this.contacts.group],
      center: [this.center, this.plumb],
      base: [this.base.group, this.capture],
      plan: [this.plan.group],
    };
    this.layers = layers;
    this.group = new THREE.Group();
    this.group.add(...Object.values(layers).flat(), this.hand.group);
  }

  setLayer(name, on) {
    for (const part of this.layers[name] ?? []) part.userData.off = !on;
  }

  show(moment) {
    this.scaleForces(moment.contacts);
    this.showSample(this.contacts, moment.contacts, null);
    this.showSample(this.plan, moment.patches, COLORS.plan);
    this.base.show(moment.contacts);
    const there = vectorOf(this.outline, moment, "com", this.vector);
    this.center.visible = there;
    this.center.position.copy(this.vector);
    this.showPlumb(there);
    this.capture.visible = vectorOf(this.outline, moment, "capture", this.vector);
    this.capture.position.copy(this.vector);
    this.showHand(moment);
    for (const part of Object.values(this.layers).flat()) {
      if (part.userData.off) part.visible = false;
      else if (part instanceof THREE.Group) part.visible = true;
    }
  }

  /** Without a known weight the first forces say what a long arrow is. */
  scaleForces(contacts) {
    if (this.perNewton) return;
    let total = 0;
    for (let i = 0; i < contacts.count; i++) total += Math.abs(contacts.values[6 * i + 5]);
    if (total > 0) this.perNewton = (WEIGHT_LENGTH * this.size) / total;
  }

  showSample(arrows, sample, color) {
    // many contacts bear little each: their arrows are drawn longer
    const length = this.perNewton * Math.sqrt(Math.max(1, sample.count) / 2);
    arrows.begin(sample.count);
    for (let i = 0; i < sample.count; i++) {
      const [x, y, z, fx, fy, fz] = sample.values.subarray(6 * i, 6 * i + 6);
      const shade = color ?? MODE_COLORS[sample.modes[i] % ON_GROUND];
      arrows.set(i, x, y, z, length * fx, length * fy, length * fz, shade);
    }
    arrows.end();
  }

  showPlumb(there) {
    const ground = this.outline.ground;
    this.plumb.visible = there && ground !== null && ground.offset !== undefined;
    if (!this.plumb.visible) return;
    const place = this.plumb.geometry.attributes.position;
    const height = this.normal.dot(this.vector) - ground.offset;
    const low = this.vector.clone().addScaledVector(this.normal, -height);
    place.setXYZ(0, ...this.vector.toArray());
    place.setXYZ(1, ...low.toArray());
    place.needsUpdate = true;
  }

  showHand(moment) {
    const pulled = vectorOf(this.outline, moment, "hand", this.vector);
    const force = vectorOf(this.outline, moment, "pull", this.force);
    const strength = this.force.length();
    this.hand.group.visible = pulled && force && strength > 0;
    if (!this.hand.group.visible) return;
    const length = Math.max(0.12 * this.size, 2 * this.perNewton * strength) / strength;
    this.hand.begin(1);
    const way = this.force.multiplyScalar(length).toArray();
    this.hand.set(0, ...this.vector.toArray(), ...way, COLORS.hand);
    this.hand.end();
  }
}

/** The hull of the character's contacts with the ground. */
class BaseOfSupport {
  constructor(size, normal) {
    this.group = new THREE.Group();
    this.lift = normal.clone().multiplyScalar(2e-3 * size);
    const axis = Math.abs(normal.x) < 0.9 ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, 1, 0);
    this.across = axis.addScaledVector(normal, -axis.dot(normal)).normalize();
    this.along = new THREE.Vector3().crossVectors(normal, this.across);
    const material = new THREE.MeshBasicMaterial({ color: COLORS.base, side: THREE.DoubleSide });
    Object.assign(material, { transparent: true, opacity: 0.28, depthWrite: false });
    this.area = new THREE.Mesh(new THREE.BufferGeometry(), material);
    this.rim = new THREE.LineLoop(
      new THREE.BufferGeometry(),
      new THREE.LineBasicMaterial({ color: COLORS.base }),
    );
    this.area.frustumCulled = this.rim.frustumCulled = false;
    this.group.add(this.area, this.rim);
  }

  show(contacts) {
    const corners = this.corners(contacts);
    this.area.visible = this.rim.visible = corners.length > 2;
    if (corners.length < 3) return;
    const places = new Float32Array(corners.flatMap((corner) => corner.toArray()));
    const faces = [];
    for (let i = 1; i + 1 < corners.length; i++) faces.push(0, i, i + 1);
    for (const part of [this.area, this.rim]) {
      part.geometry.dispose();
      part.geometry = new THREE.BufferGeometry();
      part.geometry.setAttribute("position", new THREE.BufferAttribute(places, 3));
    }
    this.area.geometry.setIndex(faces);
  }

  corners(contacts) {
    const points = [];
    for (let i = 0; i < contacts.count; i++) {
      if (contacts.modes[i] < ON_GROUND) continue;
      const [x, y, z] = contacts.values.subarray(6 * i, 6 * i + 3);
      const place = new THREE.Vector3(x, y, z).add(this.lift);
      points.push({ u: place.dot(this.across), v: place.dot(this.along), place });
    }
    return hull(points).map((point) => point.place);
  }
}

function marker(color, radius) {
  const material = new THREE.MeshBasicMaterial({ color, depthTest: false });
  const mesh = new THREE.Mesh(new THREE.SphereGeometry(radius, 20, 14), material);
  mesh.renderOrder = 3;
  mesh.material.transparent = true;
  return mesh;
}

function line(color, count) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * count), 3));
  const material = new THREE.LineBasicMaterial({ color, depthTest: false, transparent: true });
  const made = new THREE.Line(geometry, material);
  made.frustumCulled = false;
  made.renderOrder = 3;
  return made;
}
