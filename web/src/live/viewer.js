// The live 3D view: surface, path, the camera and where it was lost.
import * as THREE from 'three';
import { cameraMarker, segments } from '../shapes.js';
import { FIELD_OF_VIEW, Stage } from '../stage.js';
import { color } from '../theme.js';
import { Surface } from './surface.js';

const CAMERA_SIZE = 0.16; // metres
const SLOW = 45; // milliseconds a picture: then fewer pixels are drawn
const MIN_RESOLUTION = 0.4;
const GLIDE = 0.14; // of the way to where the follower should stand, a picture

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
    super(host, 'The run goes on all the same.', { antialias: !isSoftware() });
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
    const ends = [];
    for (let i = 0; i + 3 < this.path.length; i += 3)
      if (Math.hypot(...[0, 1, 2].map((k) => this.path[i + 3 + k] - this.path[i + k])) < 0.5) ends.push(...this.path.slice(i, i + 6));
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
    if (!this.surface.blocks.size) return;
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
    this.controls.target.lerp(target, GLIDE);
    this.camera.position.lerp(stand, GLIDE);
    this.controls.update();
  }

  draw() {
    if (this.mode === 'follow' && this.marker && this.pose) this.follow();
    if (this.mode === 'scene' && this.grown !== this.surface.blocks.size) {
      this.grown = this.surface.blocks.size;
      this.overlook();
    }
    if (this.isLost && this.marker) this.marker.scale.setScalar(1 + 0.25 * Math.sin(performance.now() / 160));
    else this.marker?.scale.setScalar(1);
    this.camera.updateMatrixWorld();
    this.surface.sky.value.copy(this.up).transformDirection(this.camera.matrixWorldInverse);
    super.draw();
    this.pace();
    for (const action of this.onDraw.splice(0)) action();
  }

  /** Fewer pixels where pictures take long, more again where there is time. */
  pace() {
    clearTimeout(this.settling);
    if (this.resolution < 1) this.settling = setTimeout(() => this.setResolution(1), 600); // nothing moves: all pixels
    const now = performance.now();
    const took = now - (this.drawnAt ?? now);
    this.drawnAt = now;
    if (took === 0 || took > 1000) return; // nothing was to be drawn in between
    this.took = (this.took ?? 30) + 0.1 * (took - (this.took ?? 30));
    const step = this.took > SLOW ? 0.75 : this.took < 0.5 * SLOW ? 1.25 : 1;
    const wanted = Math.min(1, Math.max(MIN_RESOLUTION, step * this.resolution));
    if (wanted === this.resolution || now - (this.pacedAt ?? 0) < 1500) return;
    this.pacedAt = now;
    this.setResolution(wanted);
  }

  setResolution(share) {
    this.resolution = share;
    this.resize();
  }
}
