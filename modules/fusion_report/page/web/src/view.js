// SPDX-License-Identifier: BSD-3-Clause
// The camera, its controls by mouse, touch and keys, and the drawing. Draws only when something changed.
import {Box3, ColorManagement, LinearSRGBColorSpace, PerspectiveCamera, Scene, Spherical, Vector3, WebGLRenderer} from 'three';
import {OrbitControls} from 'three/examples/jsm/controls/OrbitControls.js';

ColorManagement.enabled = false;
const kStill = 350; // ms
const kLeastFine = 1.3, kLeastCoarse = 3; // least side of a cube, pixels
const kUp = new Vector3(0, 0, 1);

/** True if no graphics card draws. */
function isSoftware(gl) {
  let name = String(gl.getParameter(gl.RENDERER));
  const info = name === 'WebKit WebGL' && gl.getExtension('WEBGL_debug_renderer_info');
  if (info) name = String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL));
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

export class View {
  /** \exception Error If the browser has no WebGL. */
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({canvas, antialias: false, preserveDrawingBuffer: true, powerPreference: 'high-performance'});
    this.inSoftware = isSoftware(this.renderer.getContext());
    this.renderer.debug.checkShaderErrors = false; // the check waits for the compiler
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(38, 1, 0.1, 1000);
    this.camera.up.copy(kUp);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.screenSpacePanning = true;
    this.controls.addEventListener('change', () => this.draw());
    this.controls.addEventListener('start', () => { this.framed = null; });
    this.after = []; // called after each frame
    this.waiting = false;
    this.started = false; // nothing is drawn before
    this.framed = null; // direction of the last look(); null after the user has moved
    this.marginOf = () => 0; // (width of the picture) -> width at its left that the controls cover, pixels
    this.margin = 0;
    this.box = new Box3(new Vector3(-1, -1, -1), new Vector3(1, 1, 1));
    this.points = [this.box.min, this.box.max]; // points that look() shows
    canvas.addEventListener('keydown', (e) => this.onKey(e));
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.resize();
  }

  resize() {
    const {clientWidth: w, clientHeight: h} = this.canvas.parentElement;
    if (w === 0 || h === 0 || (w === this.width && h === this.height)) return;
    [this.width, this.height] = [w, h];
    this.renderer.setPixelRatio(this.inSoftware ? 1 : 2); // two by two pixels smooth the edges
    this.renderer.setSize(w, h, false);
    this.camera.aspect = w / h;
    this.applyMargin();
    if (this.started && this.framed) this.look(...this.framed); // all points stay in the picture
    if (this.started) this.drawNow(!this.inSoftware);
    if (this.started && this.inSoftware) this.refine();
  }

  /** Moves the middle of the picture to the middle of the part that the controls leave open. */
  applyMargin() {
    this.margin = this.marginOf(this.width);
    if (this.margin > 0) this.camera.setViewOffset(this.width, this.height, -this.margin / 2, 0, this.width, this.height);
    else this.camera.clearViewOffset();
    this.camera.updateProjectionMatrix();
  }

  /** Draws with the next frame of the browser. */
  draw() {
    if (this.waiting || !this.started) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.drawNow(!this.inSoftware);
      if (this.inSoftware) this.refine();
    });
  }

  /** Draws with all details when the view has been still for a while. */
  refine() {
    clearTimeout(this.refining);
    this.refining = setTimeout(() => this.drawNow(true), kStill);
  }

  /** \param[in] fine If false, small cubes are joined to larger ones: less to draw without a graphics card. */
  drawNow(fine = true) {
    this.started = true;
    // Cubes that would be smaller than some pixels are joined.
    const distance = this.camera.position.distanceTo(this.controls.target);
    const scale = this.height / (2 * distance * Math.tan((this.camera.fov * Math.PI) / 360));
    this.camera.updateMatrixWorld();
    this.scene.traverseVisible((o) => o.prepare?.(this.camera, scale, fine ? kLeastFine : kLeastCoarse));
    this.renderer.render(this.scene, this.camera);
    this.canvas.dataset.detail = fine ? 'fine' : 'coarse';
    for (const f of this.after) f();
  }

  /** Looks at all points from a direction. \param[in] down Angle from straight down, rad. \param[in] around Angle
   * around the vertical, rad. */
  look(down = 0.72, around = -1.85) {
    this.framed = [down, around];
    const d = new Vector3(Math.sin(down) * Math.cos(around), Math.sin(down) * Math.sin(around), Math.cos(down));
    const fit = new PerspectiveCamera();
    fit.up.copy(kUp);
    fit.position.copy(d);
    fit.lookAt(0, 0, 0);
    fit.updateMatrixWorld();
    const x = new Vector3(), y = new Vector3(), z = new Vector3();
    fit.matrixWorld.extractBasis(x, y, z);
    // The nearest distance from which all points are in the picture. Twice: the middle depends on the distance.
    const tanY = Math.tan((this.camera.fov * Math.PI) / 360), tanX = tanY * this.camera.aspect * (1 - this.margin / this.width);
    const size = this.box.getSize(new Vector3()).length();
    const target = this.box.getCenter(new Vector3()), q = new Vector3();
    let distance = 2 * size;
    for (let pass = 0; pass < 3; pass++) {
      let [left, right, low, high, near] = [Infinity, -Infinity, Infinity, -Infinity, 0];
      for (const p of this.points) {
        q.copy(p).sub(target);
        const depth = Math.max(distance - q.dot(z), 0.05 * size);
        const [px, py] = [q.dot(x) / depth, q.dot(y) / depth];
        [left, right, low, high] = [Math.min(left, px), Math.max(right, px), Math.min(low, py), Math.max(high, py)];
      }
      target.addScaledVector(x, (distance * (left + right)) / 2).addScaledVector(y, (distance * (low + high)) / 2);
      for (const p of this.points) {
        q.copy(p).sub(target);
        near = Math.max(near, Math.abs(q.dot(x)) / tanX + q.dot(z), Math.abs(q.dot(y)) / tanY + q.dot(z));
      }
      distance = Math.max(1.06 * near, 0.05 * size);
    }
    this.controls.target.copy(target);
    this.camera.position.copy(target).addScaledVector(d, distance);
    this.camera.near = Math.max(distance, size) / 500;
    this.camera.far = 8 * Math.max(distance, size);
    this.camera.updateProjectionMatrix();
    this.controls.maxDistance = 5 * Math.max(distance, size);
    this.controls.minDistance = size / 200;
    this.controls.update();
    this.draw();
  }

  /** Turns the camera around the target, rad. */
  orbit(around, down) {
    this.framed = null;
    const offset = this.camera.position.clone().sub(this.controls.target);
    const flat = new Vector3(offset.x, offset.z, -offset.y); // y is up in Spherical
    const s = new Spherical().setFromVector3(flat);
    s.theta += around;
    s.phi = Math.min(Math.max(s.phi + down, 0.01), Math.PI - 0.01);
    flat.setFromSpherical(s);
    this.camera.position.copy(this.controls.target).add(new Vector3(flat.x, -flat.z, flat.y));
    this.controls.update();
    this.draw();
  }

  /** Multiplies the distance to the target. */
  zoom(factor) {
    this.framed = null;
    const offset = this.camera.position.clone().sub(this.controls.target);
    const length = Math.min(Math.max(offset.length() * factor, this.controls.minDistance), this.controls.maxDistance);
    this.camera.position.copy(this.controls.target).addScaledVector(offset.normalize(), length);
    this.controls.update();
    this.draw();
  }

  /** Moves camera and target by parts of the height of the picture. */
  pan(right, up) {
    this.framed = null;
    const x = new Vector3(), y = new Vector3(), z = new Vector3();
    this.camera.matrixWorld.extractBasis(x, y, z);
    const height = 2 * this.camera.position.distanceTo(this.controls.target) * Math.tan((this.camera.fov * Math.PI) / 360);
    const step = x.multiplyScalar(right * height).addScaledVector(y, up * height);
    this.camera.position.add(step);
    this.controls.target.add(step);
    this.controls.update();
    this.draw();
  }

  onKey(e) {
    if (e.ctrlKey || e.metaKey || e.altKey) return;
    const turn = 0.12, step = 0.08;
    const orbits = {ArrowLeft: [-turn, 0], ArrowRight: [turn, 0], ArrowUp: [0, -turn], ArrowDown: [0, turn]};
    const pans = {ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step]};
    if (e.shiftKey && pans[e.key]) this.pan(...pans[e.key]);
    else if (orbits[e.key]) this.orbit(...orbits[e.key]);
    else if (e.key === '+' || e.key === '=') this.zoom(0.85);
    else if (e.key === '-') this.zoom(1 / 0.85);
    else if (e.key === 'Home' || e.key === '0') this.look();
    else if (e.key === 't') this.look(0.001, -Math.PI / 2);
    else return;
    e.preventDefault();
  }
}
