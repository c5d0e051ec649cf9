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

// The report's lights, worked out at the vertices: they lie close, and where the processor draws, pixels are dear.
const VERTEX = `
#include <clipping_planes_pars_vertex>
uniform vec3 sky, clay;
varying vec3 shade;
void main() {
  vec4 mvPosition = modelViewMatrix * vec4(position, 1.0);
  gl_Position = projectionMatrix * mvPosition;
  vec3 n = normalize(normalMatrix * normal);
  n = faceforward(n, mvPosition.xyz, n);
  float lamp = max(0.0, dot(n, vec3(0.298, 0.596, 0.745)));
  shade = clay;
  #if defined(USE_COLOR) || defined(USE_COLOR_ALPHA)
    shade = color.rgb;
  #endif
  shade *= 0.668 * mix(0.69, 1.0, 0.5 + 0.5 * dot(n, sky)) + 0.509 * lamp;
  #include <clipping_planes_vertex>
}`;
const FRAGMENT = `
#include <clipping_planes_pars_fragment>
varying vec3 shade;
void main() {
  #include <clipping_planes_fragment>
  gl_FragColor = vec4(shade, 1.0);
}`;

export class Surface {
  constructor() {
    this.group = new THREE.Group();
    this.blocks = new Map();
    this.triangles = 0;
    this.shading = 'colour';
    this.planes = [];
    this.sky = { value: new THREE.Vector3(0, 1, 0) };
    this.clayColor = { value: new THREE.Color() };
    this.painted = this.material(true);
    this.clay = this.material(false);
  }

  material(vertexColors) {
    return new THREE.ShaderMaterial({ vertexColors, side: THREE.DoubleSide, clipping: true, vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms: { sky: this.sky, clay: this.clayColor } });
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

  /** Middles of the blocks' surfaces, world, and how many triangles each has. */
  middles() {
    return [...this.blocks.values()].map(({ mesh, triangles }) => {
      mesh.geometry.boundingSphere ?? mesh.geometry.computeBoundingSphere();
      return { point: mesh.geometry.boundingSphere.center.clone().multiplyScalar(mesh.scale.x).add(mesh.position), triangles };
    });
  }

  /** Middle and size of what is there, without stray parts: what lies within the distance that 85 % of the triangles do. */
  extent() {
    const middles = this.middles();
    const quantile = (values, share) => {
      const sorted = values.map((value, i) => [value, middles[i].triangles]).sort((a, b) => a[0] - b[0]);
      let left = share * sorted.reduce((sum, [, triangles]) => sum + triangles, 0);
      return sorted.find(([, triangles]) => (left -= triangles) <= 0)?.[0] ?? 0;
    };
    const center = new THREE.Vector3(...['x', 'y', 'z'].map((axis) => quantile(middles.map(({ point }) => point[axis]), 0.5)));
    return { center, radius: Math.max(0.5, quantile(middles.map(({ point }) => point.distanceTo(center)), 0.85) + 0.25) };
  }
}
