// The box that is kept: six faces to pull, with the pointer or by sliders.
import * as THREE from 'three';
import { element } from '../dom.js';
import { segments } from '../shapes.js';
import { color } from '../theme.js';

const MARGIN = 0.15; // metres around the surface, as far as the faces can be moved
const FACES = [['Left', 0, -1], ['Right', 0, 1], ['Bottom', 1, -1], ['Top', 1, 1], ['Near', 2, 1], ['Far', 2, -1]];

export class CropBox {
  /** `viewer` shows it, `panel` holds its sliders. */
  constructor(viewer, panel, { onDone }) {
    this.viewer = viewer;
    this.panel = panel;
    this.group = null;
    this.raycaster = new THREE.Raycaster();
    const button = (text, className, action) => element('button', { type: 'button', class: className, onclick: action }, text);
    this.sliders = FACES.map(([name, axis, side]) => element('input', { type: 'range', step: '0.01', 'aria-label': name, oninput: (event) => this.move(axis, side, event.target.valueAsNumber) }));
    panel.append(
      element('h2', {}, 'Keep a part'),
      element('p', {}, 'Pull the faces of the box. What lies outside is left out of the mesh; it can be changed until the run is finished.'),
      element('div', { class: 'faces' }, ...FACES.map(([name], i) => element('label', {}, element('span', {}, name), this.sliders[i]))),
      element('div', { class: 'row' },
        button('Keep the box', 'primary', () => onDone(this.value())),
        button('Keep all', '', () => onDone(null)),
        button('Cancel', '', () => onDone(undefined))),
    );
    const canvas = viewer.renderer?.domElement;
    canvas?.addEventListener('pointerdown', (event) => this.grab(event), { capture: true });
    canvas?.addEventListener('pointermove', (event) => this.pull(event));
    for (const name of ['pointerup', 'pointercancel']) canvas?.addEventListener(name, () => this.release());
  }

  /** Begins with a box around the surface, or with the one that holds. */
  open(box) {
    const points = this.viewer.surface.middles().map(({ point }) => point);
    if (!points.length) return false;
    this.frame = new THREE.Group();
    if (box) this.frame.quaternion.fromArray(box.turn);
    else this.frame.quaternion.copy(this.upright());
    const inverse = this.frame.quaternion.clone().invert();
    const around = new THREE.Box3().setFromPoints(points.map((point) => point.applyQuaternion(inverse))).expandByScalar(0.25 + MARGIN);
    this.limits = { low: around.min.toArray(), high: around.max.toArray() };
    this.low = around.min.clone().addScalar(MARGIN).toArray();
    this.high = around.max.clone().addScalar(-MARGIN).toArray();
    if (box) {
      const middle = new THREE.Vector3().fromArray(box.middle).applyQuaternion(inverse).toArray();
      this.low = middle.map((x, k) => x - box.size[k] / 2);
      this.high = middle.map((x, k) => x + box.size[k] / 2);
    }
    FACES.forEach(([, axis, side], i) => {
      this.sliders[i].min = String(Math.min(this.limits.low[axis], this.low[axis]));
      this.sliders[i].max = String(Math.max(this.limits.high[axis], this.high[axis]));
      this.sliders[i].value = String(side < 0 ? this.low[axis] : this.high[axis]);
    });
    this.panel.hidden = false;
    this.viewer.scene.add(this.frame);
    this.draw();
    return true;
  }

  close() {
    this.panel.hidden = true;
    if (this.frame) this.viewer.scene.remove(this.frame);
    this.frame = null;
    this.viewer.render();
  }

  /** y up, and the other axes along the view, so that left is left. */
  upright() {
    const { up, camera } = this.viewer;
    const back = camera.getWorldDirection(new THREE.Vector3()).negate().projectOnPlane(up).normalize();
    const right = up.clone().cross(back);
    return new THREE.Quaternion().setFromRotationMatrix(new THREE.Matrix4().makeBasis(right, up, back));
  }

  value() {
    const middle = new THREE.Vector3(...this.low.map((x, k) => (x + this.high[k]) / 2)).applyQuaternion(this.frame.quaternion);
    return { middle: middle.toArray(), turn: this.frame.quaternion.toArray(), size: this.high.map((x, k) => x - this.low[k]) };
  }

  move(axis, side, value) {
    const min = 0.05;
    if (side < 0) this.low[axis] = Math.min(value, this.high[axis] - min);
    else this.high[axis] = Math.max(value, this.low[axis] + min);
    const i = FACES.findIndex(([, a, s]) => a === axis && s === side);
    this.sliders[i].value = String(side < 0 ? this.low[axis] : this.high[axis]);
    this.draw();
  }

  draw() {
    this.frame.clear();
    const corner = (i) => [0, 1, 2].map((k) => ((i >> k) & 1 ? this.high[k] : this.low[k]));
    const ends = [];
    for (let i = 0; i < 8; i++) for (let k = 0; k < 3; k++) if (!((i >> k) & 1)) ends.push(...corner(i), ...corner(i | (1 << k)));
    const edges = segments(ends, 'accent', 2);
    edges.material.color.set(color('accent'));
    this.handles = FACES.map(([, axis, side]) => {
      const handle = new THREE.Mesh(new THREE.SphereGeometry(this.handleSize(), 16, 12), new THREE.MeshBasicMaterial({ color: color('accent'), depthTest: false, transparent: true, opacity: 0.9 }));
      handle.position.fromArray(this.low.map((x, k) => (x + this.high[k]) / 2));
      handle.position.setComponent(axis, side < 0 ? this.low[axis] : this.high[axis]);
      handle.renderOrder = 5;
      handle.userData.face = [axis, side];
      return handle;
    });
    this.frame.add(edges, ...this.handles);
    this.viewer.surface.clip(planesOf(this.value()));
    this.viewer.render();
  }

  handleSize() {
    return 0.022 * Math.max(...this.high.map((x, k) => x - this.low[k]), 1);
  }

  ray(event) {
    const { left, top, width, height } = this.viewer.renderer.domElement.getBoundingClientRect();
    const at = new THREE.Vector2((2 * (event.clientX - left)) / width - 1, 1 - (2 * (event.clientY - top)) / height);
    this.raycaster.setFromCamera(at, this.viewer.camera);
    return this.raycaster;
  }

  grab(event) {
    if (!this.frame) return;
    const [hit] = this.ray(event).intersectObjects(this.handles);
    if (!hit) return;
    this.face = hit.object.userData.face;
    this.viewer.controls.enabled = false;
    event.stopImmediatePropagation();
    event.target.setPointerCapture(event.pointerId);
  }

  /** To the point of the face's axis that is nearest to the pointer's ray. */
  pull(event) {
    if (!this.face) return;
    const [axis, side] = this.face;
    const { origin, direction } = this.ray(event).ray;
    const along = new THREE.Vector3().setComponent(axis, 1).applyQuaternion(this.frame.quaternion);
    const base = new THREE.Vector3(...this.low.map((x, k) => (k === axis ? 0 : (x + this.high[k]) / 2))).applyQuaternion(this.frame.quaternion);
    const between = base.sub(origin);
    const cosine = along.dot(direction);
    const denominator = 1 - cosine * cosine;
    if (denominator < 1e-3) return;
    this.move(axis, side, (cosine * direction.dot(between) - along.dot(between)) / denominator);
  }

  release() {
    if (!this.face) return;
    this.face = null;
    this.viewer.controls.enabled = true;
  }
}

/** What a box cuts off. */
export function planesOf(box) {
  if (!box) return [];
  const turn = new THREE.Quaternion().fromArray(box.turn);
  const middle = new THREE.Vector3().fromArray(box.middle);
  return FACES.map(([, axis, side]) => {
    const inward = new THREE.Vector3().setComponent(axis, -side).applyQuaternion(turn);
    const point = middle.clone().addScaledVector(inward, -box.size[axis] / 2);
    return new THREE.Plane().setFromNormalAndCoplanarPoint(inward, point);
  });
}
