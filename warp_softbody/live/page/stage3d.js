// Renderer, camera, lights; draws only when something has changed.

import { COLORS } from "./palette.js";
import { Sharpness } from "./sharpness.js";

const STILL = 400;
/** Pixels of the sun's map of shadows, each way, and where no graphics processor draws it. */
const SHADOW_MAP = 768;
const SOFTWARE_SHADOW_MAP = 384;

export class Stage3D {
  constructor(container, size) {
    this.container = container;
    this.software = drawsBySoftware();
    this.renderer = new THREE.WebGLRenderer({ antialias: !this.software });
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    container.append(this.renderer.domElement);
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(COLORS.background);
    this.scene.fog = new THREE.Fog(COLORS.background, 5 * size, 18 * size);
    this.camera = new THREE.PerspectiveCamera(35, 1, 0.01 * size, 60 * size);
    this.camera.up.set(0, 0, 1);
    this.controls = new THREE.OrbitControls(this.camera, this.renderer.domElement);
    this.controls.enableDamping = false;
    this.controls.maxDistance = 15 * size;
    this.controls.minDistance = 0.3 * size;
    this.controls.addEventListener("change", () => this.invalidate());
    this.addLights(size);
    this.sharpness = new Sharpness();
    this.waiting = false;
    this.drawn = 0;
    new ResizeObserver(() => this.resize()).observe(container);
    this.resize();
  }

  addLights(size) {
    this.scene.add(new THREE.HemisphereLight("#ffffff", "#aab4c2", 1.5));
    const sun = new THREE.DirectionalLight("#fff6e8", 2.0);
    sun.castShadow = true;
    const pixels = this.software ? SOFTWARE_SHADOW_MAP : SHADOW_MAP;
    sun.shadow.mapSize.set(pixels, pixels);
    sun.shadow.radius = 3;
    sun.shadow.normalBias = 0.01 * size;
    const reach = 1.4 * size;
    Object.assign(sun.shadow.camera, { left: -reach, right: reach, top: reach, bottom: -reach });
    Object.assign(sun.shadow.camera, { near: 0.1 * size, far: 8 * size });
    this.sun = sun;
    this.sunward = new THREE.Vector3(0.9, -1.3, 2.4).multiplyScalar(1.3 * size);
    this.scene.add(sun, sun.target);
  }

  /** Look at a point from the side, so that a body of this size fills the picture. */
  lookAt(target, size) {
    this.controls.target.copy(target);
    const aspect = Math.min(1, this.camera.aspect);
    const away = new THREE.Vector3(1.5, -2.3, 0.75).normalize().multiplyScalar((2.15 * size) / aspect);
    this.camera.position.copy(target).add(away);
    this.controls.update();
    this.lightUp(target);
  }

  /** Move camera, its target and the light's shadow along. */
  moveBy(change) {
    this.controls.target.add(change);
    this.camera.position.add(change);
    this.controls.update();
    this.lightUp(this.controls.target);
  }

  lightUp(target) {
    this.sun.target.position.copy(target);
    this.sun.position.copy(target).add(this.sunward);
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.container;
    if (!width || !height) return;
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.invalidate();
  }

  invalidate() {
    if (this.waiting) return;
    this.waiting = true;
    clearTimeout(this.still);
    requestAnimationFrame((now) => {
      this.waiting = false;
      this.draw(this.sharpness.after(now));
      this.still = setTimeout(() => this.drawStill(), STILL);
    });
  }

  /** Once nothing moves, draw as sharp as the screen is. */
  drawStill() {
    const full = this.sharpness.rest();
    if (this.renderer.getPixelRatio() !== full) this.draw(full);
  }

  draw(ratio) {
    if (this.renderer.getPixelRatio() !== ratio) this.renderer.setPixelRatio(ratio);
    this.renderer.render(this.scene, this.camera);
    this.drawn += 1;
  }
}

/** Whether no graphics processor draws: smooth edges would then cost most of the time. */
function drawsBySoftware() {
  const context = document.createElement("canvas").getContext("webgl2");
  const told = context?.getExtension("WEBGL_debug_renderer_info");
  const name = told ? String(context.getParameter(told.UNMASKED_RENDERER_WEBGL)) : "";
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}
