// The mesh, the paths and the camera, to turn around.
import * as THREE from 'three';
import { element } from './dom.js';
import { cameraMarker, chain, segments } from './shapes.js';
import { FIELD_OF_VIEW, Stage } from './stage.js';
import { overview, pathExtent, sceneExtent } from './view.js';

/** Green for none, over yellow to red for the end of the range: error_color.h. */
function errorColors(errors) {
  const colors = new Uint8Array(errors.length);
  for (let i = 0; i < errors.length; i += 4) {
    const share = errors[i] / 255;
    colors.set([40 + 200 * Math.min(1, 2 * share), 40 + 160 * Math.min(1, 2 - 2 * share), 50, 255], i);
  }
  return colors;
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

export class Viewer extends Stage {
  constructor(host, bar, report) {
    super(host, 'The mesh lies beside this page as mesh.ply.');
    this.report = report;
    if (!this.renderer) return;
    this.build();
    this.showBar(bar);
    this.watch();
  }

  build() {
    const { report } = this;
    this.lens = report.camera;
    this.begin(report.up);
    this.extent = sceneExtent(report);
    this.layers = this.makeLayers();
    for (const { object } of this.layers) this.scene.add(object);
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

  showFrame(row) {
    if (!this.marker) return;
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
}
