// A 3D view to turn around: what the report's and the live page's have in common.
import * as THREE from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { element } from './dom.js';
import { color, onThemeChange } from './theme.js';

// Colours are those of the screen throughout, as the page's style has them.
THREE.ColorManagement.enabled = false;

export const FIELD_OF_VIEW = 45;

/** The recording camera is drawn by `marker`, where there is one; `lens` are its intrinsics. */
export class Stage {
  /** Without WebGL there is no `renderer`, and the page says so; `advice` is what to do then. */
  constructor(host, advice, { antialias = true } = {}) {
    this.host = host;
    this.through = false;
    this.rendered = 0; // pictures so far
    this.resolution = 1; // share of the screen's
    try {
      this.renderer = new THREE.WebGLRenderer({ antialias });
    } catch {
      host.append(element('p', { class: 'no-scene' }, `This browser offers no WebGL, which the 3D view needs. ${advice}`));
      return;
    }
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
    host.append(this.renderer.domElement);
  }

  /** An empty scene. */
  begin(up) {
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(FIELD_OF_VIEW, 1, 0.01, 1000);
    this.sky = new THREE.HemisphereLight(0xffffff, 0xb5b0aa, 2.1);
    this.scene.add(this.camera, this.sky);
    const lamp = new THREE.DirectionalLight(0xffffff, 1.6);
    lamp.position.set(0.4, 0.8, 1);
    lamp.target.position.set(0, 0, -1);
    this.camera.add(lamp, lamp.target); // it comes from over the viewer's shoulder
    this.setUp(up);
  }

  /** Gravity points down, and one turns around the vertical. */
  setUp(up) {
    this.up = new THREE.Vector3().fromArray(up).normalize();
    this.camera.up.copy(this.up);
    this.sky.position.copy(this.up);
    const target = this.controls?.target.clone();
    this.controls?.dispose();
    this.controls = new OrbitControls(this.camera, this.renderer.domElement); // it reads the camera's up once
    if (target) this.controls.target.copy(target);
    this.controls.addEventListener('change', () => this.render());
  }

  /** Follows the page's colours and size from now on. */
  watch() {
    this.paint();
    onThemeChange(() => this.paint());
    new ResizeObserver(() => this.resize()).observe(this.host);
  }

  /** Colours of the page's style into the scene. */
  paint() {
    this.scene.background = new THREE.Color(color('scene'));
    this.scene.traverse((object) => {
      const name = object.userData.color ?? object.material?.userData.color;
      if (name && object.material.color) object.material.color.set(color(name));
    });
    this.render();
  }

  /** Stands where the recording camera stands, and follows it. */
  lookThrough(through) {
    if (through) this.before = this.camera.position.clone();
    this.through = through;
    this.controls.enabled = !through;
    for (const child of this.marker.children) child.visible = !through; // not from within
    if (through) {
      this.placeThrough();
    } else {
      this.camera.position.copy(this.before);
      this.controls.update();
    }
    this.setLens();
    this.render();
  }

  placeThrough() {
    const turn = new THREE.Quaternion();
    // Images have y down and look along z; three's cameras have y up and look along -z.
    turn.setFromAxisAngle(this.lens.fy > 0 ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, 1, 0), Math.PI);
    this.camera.position.copy(this.marker.position);
    this.camera.quaternion.copy(this.marker.quaternion).multiply(turn);
  }

  resize() {
    if (this.setSize()) this.draw(); // at once: a resized canvas is blank
  }

  /** False while the view has no size. */
  setSize() {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (!width || !height) return false;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio || 1, 2) * this.resolution);
    this.renderer.setSize(width, height);
    this.setLens();
    return true;
  }

  setLens() {
    this.camera.aspect = this.host.clientWidth / Math.max(1, this.host.clientHeight);
    this.camera.fov = FIELD_OF_VIEW;
    if (this.through) {
      const k = this.lens;
      const half = Math.max(k.height / 2 / Math.abs(k.fy), k.width / 2 / k.fx / this.camera.aspect); // the whole image fits
      this.camera.fov = (2 * 180 * Math.atan(half)) / Math.PI;
    }
    this.camera.updateProjectionMatrix();
  }

  /** Draws with the browser's next picture, once, however often it is asked. */
  render() {
    this.pending ??= requestAnimationFrame(() => this.draw());
  }

  draw() {
    if (this.pending) cancelAnimationFrame(this.pending);
    this.pending = null;
    this.renderer.render(this.scene, this.camera);
    this.rendered++;
  }
}
