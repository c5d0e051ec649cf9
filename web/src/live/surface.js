// The surface, block by block, as it comes.
import * as THREE from 'three';
import { decodeIndices, decodeVertices } from '../decode.js';

/** From red for what two frames saw, over yellow, to blue for what will hardly change; `seen` as it comes, 255 is well. */
export function seenColors(seen) {
  const colors = new Uint8Array(seen.length);
  for (let i = 0; i < seen.length; i += 4) {
    const share = Math.sqrt(seen[i] / 255);
    const from = share < 0.5 ? [222, 84, 66] : [232, 190, 84];
    const to = share < 0.5 ? [232, 190, 84] : [66, 150, 190];
    const t = share < 0.5 ? 2 * share : 2 * share - 1;
    for (let k = 0; k < 3; k++) colors[i + k] = from[k] + t * (to[k] - from[k]);
    colors[i + 3] = 255;
  }
  return colors;
}

export class Surface {
  constructor() {
    this.group = new THREE.Group();
    this.blocks = new Map();
    this.triangles = 0;
    this.shading = 'colour';
    this.planes = [];
    this.painted = new THREE.MeshLambertMaterial({ vertexColors: true, side: THREE.DoubleSide });
    this.clay = new THREE.MeshLambertMaterial({ side: THREE.DoubleSide });
    this.clay.userData.color = 'clay';
  }

  clear() {
    for (const key of [...this.blocks.keys()]) this.remove(key);
  }

  remove(key) {
    const block = this.blocks.get(key);
    if (!block) return;
    this.group.remove(block.mesh);
    block.mesh.geometry.dispose();
    this.triangles -= block.triangles;
    this.blocks.delete(key);
  }

  /** A block's surface replaces what there was of it. */
  set({ block: position, vertices, triangles, origin, step, buffers }) {
    const key = position.join();
    this.remove(key);
    const indices = decodeIndices(buffers.indices, triangles);
    if (!indices) return;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(decodeVertices(buffers.positions, vertices, Uint16Array), 4));
    geometry.setAttribute('normal', new THREE.BufferAttribute(decodeVertices(buffers.normals, vertices, Int8Array), 4, true));
    geometry.setIndex(new THREE.BufferAttribute(indices, 1));
    const mesh = new THREE.Mesh(geometry);
    mesh.position.fromArray(origin);
    mesh.scale.setScalar(step);
    const block = { mesh, triangles, step, colors: decodeVertices(buffers.colors, vertices, Uint8Array), seen: decodeVertices(buffers.seen, vertices, Uint8Array) };
    this.blocks.set(key, block);
    this.triangles += triangles;
    this.shadeBlock(block);
    this.group.add(mesh);
  }

  get hasColors() {
    for (const { colors } of this.blocks.values()) return Boolean(colors);
    return true;
  }

  /** "colour", "clay" or "seen". */
  shade(name) {
    this.shading = name;
    for (const block of this.blocks.values()) this.shadeBlock(block);
  }

  shadeBlock({ mesh, colors, seen }) {
    const bytes = this.shading === 'seen' ? seenColors(seen) : this.shading === 'colour' ? colors : null;
    if (bytes) mesh.geometry.setAttribute('color', new THREE.BufferAttribute(bytes, 4, true));
    else mesh.geometry.deleteAttribute('color');
    mesh.material = bytes ? this.painted : this.clay;
  }

  /** Only what lies on the inner side of all planes is drawn. */
  clip(planes) {
    for (const material of [this.painted, this.clay]) material.clippingPlanes = planes;
  }

  /** Middles of the blocks' surfaces, world. */
  middles() {
    return [...this.blocks.values()].map(({ mesh }) => {
      mesh.geometry.boundingSphere ?? mesh.geometry.computeBoundingSphere();
      return mesh.geometry.boundingSphere.center.clone().multiplyScalar(mesh.scale.x).add(mesh.position);
    });
  }
}
