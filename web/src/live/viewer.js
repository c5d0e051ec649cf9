// The live 3D view: surface, path, the camera and where it was lost.
import * as THREE from 'three';
import { cameraMarker, segments } from '../shapes.js';
import { FIELD_OF_VIEW, Stage } from '../stage.js';
import { color } from '../theme.js';
import { Surface } from './surface.js';

const CAMERA_SIZE = 0.16; // metres
const TARGET = 24; // milliseconds a picture
const MIN_EFFORT = 0.15;
const REST = 500; // milliseconds without a change: then everything is drawn
const GLIDE = 0.25; // seconds in which the follower comes near to where it should stand
const MAX_PATH = 300; // pieces

/** How many triangles, and what share of the pixels along a side, an effort from 0 to 1 stands for. */
const budgetOf = (effort) => 4000 * 500 ** effort;
const resolutionOf = (effort) => Math.min(1, Math.max(0.5, Math.round(8 * (1.7 * effort)) / 8));

/** Whether pictures are drawn by the processor. */
function isSoftware() {
  const context = document.createElement('canvas').getContext('webgl2');
  const info = context?.getExtension('WEBGL_debug_renderer_info');
  const name = info ? context.getParameter(info.UNMASKED_RENDERER_WEBGL) : '';
  context?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

export class LiveViewer extends Stage {
  constructor(host) {
    const isSlow = isSoftware();
    super(host, 'The run goes on all the same.', { antialias: !isSlow });
    document.body.classList.toggle('slow', isSlow);
    this.isSlow = isSlow;
    this.effort = isSlow ? 0.3 : 1;
    this.resolution = resolutionOf(this.effort);
    this.inFlight = 0; // pictures that are being drawn
    this.mode = 'follow';
    this.surface = new Surface();
    this.path = [];
    this.onDraw = [];
    if (!this.renderer) return;
    this.renderer.localClippingEnabled = true;
    this.begin([0, -1, 0]);
    this.camera.near = 0.02;
    this.camera.far = 200;
    this.camera.position.set(0, -0.7, -1.6);
    this.controls.target.set(0, 0, 1.5);
    this.controls.update();
    this.scene.add(this.surface.group);
    this.pathLines = null;
    this.watch();
  }

  setUp(up) {
    super.setUp(up);
    this.controls.addEventListener('start', () => this.setMode('free'));
  }

  /** A run begins, or begins anew. */
  setScene({ camera, buffers }) {
    this.surface.clear();
    this.path = buffers.path?.length ? [...new Float32Array(buffers.path.slice().buffer)] : [];
    if (!this.renderer) return;
    this.lens = camera;
    if (this.marker) this.scene.remove(this.marker);
    this.marker = camera.width > 0 ? cameraMarker(camera, CAMERA_SIZE) : null;
    if (this.marker) this.scene.add(this.marker);
    this.drawnPath = 0;
    this.drawPath();
    this.paint();
  }

  /** Pose (x y z, quaternion) of the newest frame, or of the latest that had one. */
  setPose(pose, isLost, isNew) {
    this.pose = pose;
    if (!this.marker) return;
    this.marker.position.fromArray(pose);
    this.marker.quaternion.fromArray(pose, 3);
    this.setLost(isLost);
    if (isNew && !isLost) {
      this.path.push(...pose.slice(0, 3));
      this.drawPath();
    }
    if (this.through) this.placeThrough();
  }

  setLost(isLost) {
    if (this.isLost === isLost) return;
    this.isLost = isLost;
    this.marker.traverse((object) => {
      if (object.userData.color) object.userData.color = isLost ? 'lost' : 'camera';
    });
    this.paint();
  }

  /** Gravity; small corrections are not worth a jolt. */
  setGravity(up) {
    const direction = new THREE.Vector3().fromArray(up);
    if (this.renderer && direction.angleTo(this.up) > 0.06) this.setUp(up);
  }

  drawPath() {
    if (this.pathLines && this.path.length - this.drawnPath < 30) return; // ten positions more
    this.drawnPath = this.path.length;
    if (this.pathLines) {
      this.scene.remove(this.pathLines);
      this.pathLines.geometry.dispose();
    }
    const ends = thinned(this.path);
    this.pathLines = segments(ends, 'estimate', 2);
    this.pathLines.material.color.set(color('estimate'));
    this.scene.add(this.pathLines);
  }

  paint() {
    this.surface.clayColor.value.set(color('clay'));
    super.paint();
  }

  /** "follow" stands behind the camera, "scene" sees all, "through" sees what it sees, "free" is where one turned it. */
  setMode(mode) {
    if (mode === this.mode) return;
    if (this.through && this.marker) this.lookThrough(false);
    this.mode = mode;
    if (mode === 'through' && this.marker) this.lookThrough(true);
    if (mode === 'scene') this.overlook();
    this.onMode?.(mode);
    this.render();
  }

  /** All of the surface in sight, from where it is seen now. */
  overlook() {
    if (!this.surface.size) return;
    const { center, radius } = this.surface.extent();
    const back = this.camera.position.clone().sub(this.controls.target).projectOnPlane(this.up);
    if (back.lengthSq() < 1e-6) back.set(this.up.y, this.up.z, this.up.x).projectOnPlane(this.up);
    const direction = back.normalize().addScaledVector(this.up, 0.55).normalize();
    this.controls.target.copy(center);
    this.camera.position.copy(center).addScaledVector(direction, (0.95 * radius) / Math.sin((FIELD_OF_VIEW * Math.PI) / 360) / Math.min(1, this.camera.aspect));
    this.controls.update();
  }

  /** Behind and above the camera, towards what it looks at. */
  follow() {
    const forward = new THREE.Vector3(0, 0, 1).applyQuaternion(this.marker.quaternion);
    const level = forward.clone().projectOnPlane(this.up);
    if (level.lengthSq() < 0.02) level.copy(this.camera.position).sub(this.controls.target).projectOnPlane(this.up).negate();
    level.normalize();
    const target = this.marker.position.clone().addScaledVector(forward, 1.4);
    const stand = this.marker.position.clone().addScaledVector(level, -1.5).addScaledVector(this.up, 0.9);
    const now = performance.now();
    const seconds = Math.min(0.2, (now - (this.followedAt ?? now - 30)) / 1e3);
    const share = 1 - Math.exp(-seconds / GLIDE);
    this.followedAt = now;
    this.controls.target.lerp(target, share);
    this.camera.position.lerp(stand, share);
    this.controls.update();
  }

  /** Draws a change; `onDrawn` is called once it is drawn, which a page in the background does not do. */
  show(onDrawn) {
    const now = performance.now();
    this.interval = Math.min(2000, now - (this.shownAt ?? now));
    this.shownAt = now;
    this.onDraw.push(onDrawn);
    this.resting = false;
    if (document.hidden) this.render();
    else this.draw();
  }

  /** One picture after the other: what is to be drawn meanwhile is drawn after it. */
  render() {
    if (this.isPlacing) return;
    this.resting = false;
    if (this.inFlight) this.again = true;
    else super.render();
  }

  draw() {
    this.place();
    if (this.isLost && this.marker) this.marker.scale.setScalar(1 + 0.25 * Math.sin(performance.now() / 160));
    else this.marker?.scale.setScalar(1);
    this.setResolution(this.resting ? 1 : resolutionOf(this.effort));
    this.camera.updateMatrixWorld();
    this.surface.sky.value.copy(this.up).transformDirection(this.camera.matrixWorldInverse);
    this.surface.prepare(this.camera, this.resting ? Infinity : budgetOf(this.effort));
    const begin = performance.now();
    super.draw();
    const actions = this.onDraw.splice(0);
    const { resting } = this;
    this.inFlight++;
    finished(this.renderer.getContext()).then(() => {
      this.inFlight--;
      for (const action of actions) action();
      if (!resting) this.pace(performance.now() - begin);
      if (this.again) this.render();
      this.again = false;
    });
  }

  /** As many triangles and pixels as there is time for, and all of them once nothing moves. */
  pace(took) {
    this.took = took;
    if (took > TARGET) this.effort = Math.max(MIN_EFFORT, this.effort - (took > 2 * TARGET ? 0.06 : 0.02));
    else if (took < 0.6 * TARGET) this.effort = Math.min(1, this.effort + 0.01);
    clearTimeout(this.settling);
    this.settling = setTimeout(() => {
      this.resting = true;
      if (!this.inFlight) this.draw();
    }, Math.max(REST, 4 * (this.interval ?? 0))); // a slow machine's pause between two updates is none
  }

  /** Where the view's camera moves by itself. */
  place() {
    this.isPlacing = true;
    if (this.mode === 'follow' && this.marker && this.pose && !this.resting) this.follow();
    if (this.mode === 'scene' && this.grown !== this.surface.size) {
      this.grown = this.surface.size;
      this.overlook();
    }
    this.isPlacing = false;
  }

  setResolution(share) {
    const now = performance.now();
    const isChange = share !== this.resolution && (share === 1 || this.resolution === 1 || now - (this.resizedAt ?? 0) > 1000);
    if (!isChange) return;
    this.resizedAt = now;
    this.resolution = share;
    this.setSize();
  }
}

/** The path as pairs of ends, in few enough pieces. */
function thinned(path) {
  for (let spacing = 0.01; ; spacing *= 2) {
    const ends = [];
    for (let from = 0, i = 3; i + 2 < path.length; i += 3) {
      const distance = Math.hypot(path[i] - path[from], path[i + 1] - path[from + 1], path[i + 2] - path[from + 2]);
      if (distance < spacing && i + 5 < path.length) continue;
      if (distance < 0.5) ends.push(...path.slice(from, from + 3), ...path.slice(i, i + 3));
      from = i;
    }
    if (ends.length <= 6 * MAX_PATH || spacing > 0.4) return ends;
  }
}

/** Resolves when all that was to be drawn so far is drawn. */
function finished(gl) {
  const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
  gl.flush();
  return new Promise((resolve) => {
    const look = () => {
      const status = fence && !gl.isContextLost() ? gl.clientWaitSync(fence, 0, 0) : gl.WAIT_FAILED;
      if (status === gl.TIMEOUT_EXPIRED) return setTimeout(look, 2);
      if (fence) gl.deleteSync(fence);
      resolve();
    };
    setTimeout(look, 2);
  });
}
