// The mesh, the paths and the camera, to turn around.
import * as THREE from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';
import { element } from './dom.js';
import { color, onThemeChange } from './theme.js';
import { overview, pathExtent, sceneExtent } from './view.js';

// Colours are those of the screen throughout, as the page's style has them.
THREE.ColorManagement.enabled = false;

const FIELD_OF_VIEW = 45;

/** Green for none, over yellow to red for the end of the range: error_color.h. */
function errorColors(errors) {
  const colors = new Uint8Array(errors.length);
  for (let i = 0; i < errors.length; i += 4) {
    const share = errors[i] / 255;
    colors.set([40 + 200 * Math.min(1, 2 * share), 40 + 160 * Math.min(1, 2 - 2 * share), 50, 255], i);
  }
  return colors;
}

/** Lines of a width in pixels; `points` holds pairs of ends, x y z each. */
function segments(points, name, width) {
  const geometry = new LineSegmentsGeometry();
  geometry.setPositions(points.length ? points : [0, 0, 0, 0, 0, 0]);
  // Over the mesh: where the path is matters more than what stands before it.
  const lines = new LineSegments2(geometry, new LineMaterial({ linewidth: width, depthTest: false, transparent: true }));
  lines.visible = points.length > 0;
  lines.frustumCulled = false;
  lines.userData.color = name;
  lines.renderOrder = name === 'difference' ? 1 : 2; // the paths stay visible over what joins them
  return lines;
}

/** A chain of points as pairs of ends; where `joined(i)` is false, nothing leads from point i to the next. */
function chain(count, point, joined = () => true) {
  const ends = [];
  for (let i = 0; i + 1 < count; i++) if (joined(i)) ends.push(...point(i), ...point(i + 1));
  return ends;
}

function meshObject(mesh) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(mesh.positions, 4));
  if (mesh.normals) geometry.setAttribute('normal', new THREE.BufferAttribute(mesh.normals, 4, true));
  if (mesh.indices) geometry.setIndex(new THREE.BufferAttribute(mesh.indices, 1));
  if (mesh.indices && !mesh.normals) geometry.computeVertexNormals();
  const object = mesh.indices
    ? new THREE.Mesh(geometry, new THREE.MeshLambertMaterial())
    : new THREE.Points(geometry, new THREE.PointsMaterial({ size: 1.5, sizeAttenuation: false }));
  object.position.fromArray(mesh.origin);
  object.scale.setScalar(mesh.step);
  return object;
}

/** The camera as a pyramid of its field of view, `depth` metres long. */
function cameraMarker({ width, height, fx, fy, cx, cy }, depth) {
  const corner = (u, v) => [((u - cx) / fx) * depth, ((v - cy) / fy) * depth, depth];
  const corners = [corner(0, 0), corner(width, 0), corner(width, height), corner(0, height)];
  const top = [(corners[0][0] + corners[1][0]) / 2, corners[0][1] - Math.sign(fy) * 0.25 * depth, depth];
  const ends = [];
  corners.forEach((c, i) => ends.push(0, 0, 0, ...c, ...c, ...corners[(i + 1) % 4]));
  ends.push(...corners[0], ...top, ...top, ...corners[1]);
  const marker = new THREE.Group();
  const face = new THREE.BufferGeometry();
  face.setAttribute('position', new THREE.Float32BufferAttribute(corners.flat(), 3));
  face.setIndex([0, 1, 2, 0, 2, 3]);
  const plane = new THREE.Mesh(face, new THREE.MeshBasicMaterial({ transparent: true, opacity: 0.18, side: THREE.DoubleSide, depthWrite: false }));
  plane.userData.color = 'camera';
  marker.add(segments(ends, 'camera', 2), plane);
  return marker;
}

export class Viewer {
  constructor(host, bar, report) {
    this.host = host;
    this.report = report;
    this.through = false;
    this.rendered = 0; // pictures so far
    try {
      this.renderer = new THREE.WebGLRenderer({ antialias: true });
    } catch {
      host.append(element('p', { class: 'no-scene' }, 'This browser offers no WebGL, which the 3D view needs. The mesh lies beside this page as mesh.ply.'));
      return;
    }
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
    host.append(this.renderer.domElement);
    this.build();
    this.showBar(bar);
    this.paint();
    onThemeChange(() => this.paint());
    new ResizeObserver(() => this.resize()).observe(host);
  }

  build() {
    const { report } = this;
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(FIELD_OF_VIEW, 1, 0.01, 1000);
    this.camera.up.fromArray(report.up);
    const sky = new THREE.HemisphereLight(0xffffff, 0xb5b0aa, 2.1);
    sky.position.fromArray(report.up);
    this.scene.add(this.camera, sky);
    const lamp = new THREE.DirectionalLight(0xffffff, 1.6);
    lamp.position.set(0.4, 0.8, 1);
    lamp.target.position.set(0, 0, -1);
    this.camera.add(lamp, lamp.target); // it comes from over the viewer's shoulder
    this.extent = sceneExtent(report);
    this.layers = this.makeLayers();
    for (const { object } of this.layers) this.scene.add(object);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener('change', () => this.render());
    this.home();
  }

  /** What can be shown and hidden, in the order of the bar. */
  makeLayers() {
    const { report } = this;
    const layers = [];
    if (report.mesh) {
      this.mesh = meshObject(report.mesh);
      layers.push({ name: 'Mesh', object: this.mesh });
    }
    if (report.path) layers.push({ name: 'Path', swatch: 'estimate', object: segments(chain(report.path.length / 3, (i) => report.path.subarray(3 * i, 3 * i + 3)), 'estimate', 2.5) });
    if (!report.frames) return layers;
    layers.push({ name: 'Estimate', swatch: 'estimate', object: this.estimatedPath() });
    if (report.truePath?.length) {
      const { truePath } = report;
      layers.push({ name: 'Truth', swatch: 'truth', object: segments(chain(truePath.length / 3, (i) => truePath.subarray(3 * i, 3 * i + 3)), 'truth', 2) });
      layers.push({ name: 'Difference', swatch: 'difference', object: this.differences() });
    }
    this.marker = cameraMarker(report.camera, 0.07 * this.extent.radius);
    layers.push({ name: 'Camera', swatch: 'camera', object: this.marker });
    return layers;
  }

  estimatedPath() {
    const { frames, names } = this.report;
    const tracked = (i) => frames.at('status', i) !== names.status.indexOf('lost');
    return segments(chain(frames.rows, (i) => frames.position(i), (i) => tracked(i) && tracked(i + 1)), 'estimate', 2.5);
  }

  differences() {
    const { frames } = this.report;
    const ends = [];
    for (let i = 0; i < frames.rows; i++)
      if (Number.isFinite(frames.at('true_tx', i))) ends.push(...frames.position(i), ...frames.truePosition(i));
    return segments(ends, 'difference', 1);
  }

  showBar(bar) {
    const toggles = this.layers.map(({ name, swatch, object }) =>
      element('button', { type: 'button', class: 'chip', 'aria-pressed': 'true', onclick: (event) => {
        object.visible = !object.visible;
        event.currentTarget.setAttribute('aria-pressed', String(object.visible));
        this.render();
      } }, swatch ? element('i', { style: `background:var(--${swatch})` }) : null, name));
    const shadings = this.shadings();
    const legend = element('span', { class: 'legend', hidden: true }, 'none', element('i'), this.report.mesh ? `${1e3 * this.report.mesh.error_range_m} mm and more` : '');
    const choose = (name) => {
      this.shade(name);
      legend.hidden = name !== 'Error';
    };
    const select = shadings.length < 2 ? null : element('select', { 'aria-label': 'Colours of the mesh', onchange: (event) => choose(event.target.value) }, ...shadings.map((name) => element('option', {}, name)));
    const look = element('button', { type: 'button', class: 'chip', 'aria-pressed': 'false', onclick: () => {
      this.lookThrough(!this.through);
      look.setAttribute('aria-pressed', String(this.through));
    } }, 'Camera’s view');
    const stand = (name, extent) => element('button', { type: 'button', class: 'chip', onclick: () => {
      if (this.through) look.click();
      this.home(extent());
    } }, name);
    const views = [stand('Scene', () => this.extent)];
    if (this.report.frames) views.push(stand('Path', () => pathExtent(this.report)), look);
    bar.append(element('div', { class: 'group' }, ...toggles), element('div', { class: 'group' }, legend, select, ...views));
    if (this.mesh) choose(shadings[0]);
  }

  shadings() {
    const { mesh } = this.report;
    if (!mesh) return [];
    return [mesh.colors && 'Colour', 'Clay', mesh.errors && 'Error', mesh.indices && 'Normals'].filter(Boolean);
  }

  shade(name) {
    const { geometry } = this.mesh;
    const { colors, errors, indices } = this.report.mesh;
    const bytes = name === 'Colour' ? colors : name === 'Error' ? errorColors(errors) : null;
    if (bytes) geometry.setAttribute('color', new THREE.BufferAttribute(bytes, 4, true));
    else geometry.deleteAttribute('color');
    this.mesh.material.dispose();
    if (!indices) this.mesh.material = new THREE.PointsMaterial({ size: 1.5, sizeAttenuation: false, vertexColors: Boolean(bytes) });
    else if (name === 'Normals') this.mesh.material = new THREE.MeshNormalMaterial();
    else this.mesh.material = new THREE.MeshLambertMaterial({ vertexColors: Boolean(bytes) });
    if (!bytes) this.mesh.material.userData.color = 'clay';
    this.paint();
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

  showFrame(row) {
    if (!this.marker) return;
    this.row = row;
    this.marker.position.fromArray(this.report.frames.position(row));
    this.marker.quaternion.fromArray(this.report.frames.quaternion(row));
    if (this.through) this.placeThrough();
    this.render();
  }

  home(extent = this.extent) {
    const { position, target } = overview(this.report, extent, FIELD_OF_VIEW);
    this.camera.position.copy(position);
    this.camera.near = extent.radius / 500;
    this.camera.far = this.extent.radius * 100;
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(target);
    this.controls.update();
    this.render();
  }

  /** Stands where the recording camera stood, and follows it. */
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
    turn.setFromAxisAngle(this.report.camera.fy > 0 ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, 1, 0), Math.PI);
    this.camera.position.fromArray(this.report.frames.position(this.row));
    this.camera.quaternion.fromArray(this.report.frames.quaternion(this.row)).multiply(turn);
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.host;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio || 1, 2));
    this.renderer.setSize(width, height);
    this.setLens();
    this.draw(); // at once: a resized canvas is blank
  }

  setLens() {
    this.camera.aspect = this.host.clientWidth / Math.max(1, this.host.clientHeight);
    this.camera.fov = FIELD_OF_VIEW;
    if (this.through) {
      const { camera: k } = this.report;
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
