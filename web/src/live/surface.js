// The surface, block by block, as it comes. Blocks of a region are drawn as one, with as many triangles as there is time for.
import * as THREE from 'three';
import { decodeIndices, decodeVertices } from '../decode.js';

const HYSTERESIS = 1.2; // a region is drawn coarser only when the triangles are so much more than there is time for
const GRID_MIDDLE = 32767.5; // of what positions are counted in: the region's blocks lie in the ball around it

/** From red for what was hardly seen, over yellow, to blue for what will hardly change; 255 is well. */
export function seenColor(value) {
  const share = Math.sqrt(value / 255);
  const from = share < 0.5 ? [222, 84, 66] : [232, 190, 84];
  const to = share < 0.5 ? [232, 190, 84] : [66, 150, 190];
  const t = share < 0.5 ? 2 * share : 2 * share - 1;
  return [0, 1, 2].map((k) => from[k] + t * (to[k] - from[k]));
}

const SEEN = new Uint32Array(new Uint8Array(Array.from({ length: 256 }, (_, i) => [...seenColor(i), 255]).flat()).buffer);

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

function decodeBlock({ vertices, levels, origin, step, buffers }) {
  const positions = decodeVertices(buffers.positions, vertices, Uint16Array);
  const low = [65535, 65535, 65535], high = [0, 0, 0];
  for (let i = 0; i < positions.length; i++)
    if ((i & 3) < 3) {
      low[i & 3] = Math.min(low[i & 3], positions[i]);
      high[i & 3] = Math.max(high[i & 3], positions[i]);
    }
  return {
    vertices, positions,
    normals: decodeVertices(buffers.normals, vertices, Int8Array),
    colors: decodeVertices(buffers.colors, vertices, Uint8Array),
    seen: decodeVertices(buffers.seen, vertices, Uint8Array),
    indices: levels.map((triangles, i) => decodeIndices(buffers[`indices${i}`], triangles) ?? new Uint32Array(0)),
    middle: new THREE.Vector3(...low.map((x, k) => origin[k] + (step * (x + high[k])) / 2)),
  };
}

/** Blocks that are drawn by one call, out of buffers with room for some more. */
class Region {
  constructor(origin, step) {
    this.blocks = new Map();
    this.triangles = [0, 0, 0];
    this.level = 2;
    this.mesh = new THREE.Mesh(new THREE.BufferGeometry());
    this.mesh.position.fromArray(origin);
    this.mesh.scale.setScalar(step);
    const sphere = new THREE.Sphere(new THREE.Vector3(GRID_MIDDLE, GRID_MIDDLE, GRID_MIDDLE), GRID_MIDDLE);
    this.mesh.geometry.boundingSphere = sphere;
    this.sphere = new THREE.Sphere(sphere.center.clone().multiplyScalar(step).add(this.mesh.position), sphere.radius * step);
    this.isStale = true;
  }

  set(key, block) {
    const old = this.blocks.get(key);
    for (let i = 0; i < 3; i++) this.triangles[i] += ((block?.indices[i].length ?? 0) - (old?.indices[i].length ?? 0)) / 3;
    if (block) this.blocks.set(key, block);
    else this.blocks.delete(key);
    this.isStale = true;
  }

  setLevel(level) {
    if (level === this.level) return;
    this.level = level;
    this.isStale = true;
  }

  attribute(name, Type, count, normalized = false) {
    const { geometry } = this.mesh;
    let attribute = geometry.getAttribute(name);
    if (!attribute || attribute.count < count) {
      if (attribute) this.renew();
      attribute = new THREE.BufferAttribute(new Type(4 * Math.ceil(1.5 * count)), 4, normalized);
      geometry.setAttribute(name, attribute);
    }
    attribute.clearUpdateRanges();
    attribute.addUpdateRange(0, 4 * count);
    attribute.needsUpdate = true;
    return attribute.array;
  }

  indexArray(count) {
    const { geometry } = this.mesh;
    if (!geometry.index || geometry.index.count < count) {
      if (geometry.index) this.renew();
      geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(Math.ceil(1.5 * count)), 1));
    }
    geometry.index.clearUpdateRanges();
    geometry.index.addUpdateRange(0, count);
    geometry.index.needsUpdate = true;
    return geometry.index.array;
  }

  /** Without the buffers that the graphics card holds; those of before are too small. */
  renew() {
    const { boundingSphere } = this.mesh.geometry;
    this.mesh.geometry.dispose();
    this.mesh.geometry = new THREE.BufferGeometry();
    this.mesh.geometry.boundingSphere = boundingSphere;
  }

  /** Fills the buffers, if something has changed. */
  build(shading) {
    if (!this.isStale) return;
    this.isStale = false;
    const blocks = [...this.blocks.values()];
    const vertices = blocks.reduce((sum, block) => sum + block.vertices, 0);
    const count = 3 * this.triangles[this.level];
    this.mesh.visible = count > 0;
    if (!count) return;
    const { geometry } = this.mesh;
    if ((geometry.index?.count ?? 0) < count || (geometry.getAttribute('position')?.count ?? 0) < vertices) this.renew();
    const positions = this.attribute('position', Uint16Array, vertices), normals = this.attribute('normal', Int8Array, vertices, true);
    const colors = shading === 'clay' ? null : this.attribute('color', Uint8Array, vertices, true);
    const words = colors && new Uint32Array(colors.buffer);
    const indices = this.indexArray(count);
    let first = 0, at = 0;
    for (const block of blocks) {
      positions.set(block.positions, 4 * first);
      normals.set(block.normals, 4 * first);
      if (shading === 'colour' && block.colors) colors.set(block.colors, 4 * first);
      if (shading === 'seen') for (let i = 0; i < block.vertices; i++) words[first + i] = SEEN[block.seen[4 * i]];
      for (const index of block.indices[this.level]) indices[at++] = first + index;
      first += block.vertices;
    }
    this.mesh.geometry.setDrawRange(0, count);
  }
}

export class Surface {
  constructor() {
    this.group = new THREE.Group();
    this.regions = new Map();
    this.homes = new Map(); // of each block, its region
    this.shading = 'colour';
    this.sky = { value: new THREE.Vector3(0, 1, 0) };
    this.clayColor = { value: new THREE.Color() };
    this.painted = this.material(true);
    this.clay = this.material(false);
    this.frustum = new THREE.Frustum();
    this.drawn = 0; // triangles of the latest picture
  }

  material(vertexColors) {
    return new THREE.ShaderMaterial({ vertexColors, side: THREE.DoubleSide, clipping: true, vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms: { sky: this.sky, clay: this.clayColor } });
  }

  get triangles() {
    let sum = 0;
    for (const region of this.regions.values()) sum += region.triangles[0];
    return sum;
  }

  get size() {
    return this.homes.size;
  }

  get hasColors() {
    for (const { blocks } of this.regions.values()) for (const { colors } of blocks.values()) return Boolean(colors);
    return true;
  }

  clear() {
    for (const { mesh } of this.regions.values()) mesh.geometry.dispose();
    this.group.clear();
    this.regions.clear();
    this.homes.clear();
  }

  /** A block's surface replaces what there was of it. */
  set(message) {
    const key = message.block.join(), home = message.region.join();
    const isEmpty = !message.levels.length;
    if (!this.regions.has(home)) {
      if (isEmpty) return;
      const region = new Region(message.origin, message.step);
      this.regions.set(home, region);
      this.group.add(region.mesh);
    }
    if (isEmpty) this.homes.delete(key);
    else this.homes.set(key, home);
    this.regions.get(home).set(key, isEmpty ? null : decodeBlock(message));
  }

  /** "colour", "clay" or "seen". */
  shade(name) {
    this.shading = name;
    for (const region of this.regions.values()) region.isStale = true;
  }

  /** Only what lies on the inner side of all planes is drawn. */
  clip(planes) {
    for (const material of [this.painted, this.clay]) material.clippingPlanes = planes;
  }

  /** Makes ready what the camera sees: finer where it is near, as far as `budget` triangles go. */
  prepare(camera, budget) {
    this.frustum.setFromProjectionMatrix(new THREE.Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse));
    const seen = [...this.regions.values()].filter(({ sphere }) => this.frustum.intersectsSphere(sphere));
    const distance = new Map(seen.map((region) => [region, region.sphere.distanceToPoint(camera.position)]));
    seen.sort((a, b) => distance.get(a) - distance.get(b));
    let triangles = seen.reduce((sum, region) => sum + region.triangles[2], 0);
    const levels = new Map(seen.map((region) => [region, 2]));
    for (const level of [1, 0])
      for (const region of seen) {
        const more = region.triangles[level] - region.triangles[level + 1];
        if (triangles + more > budget * (region.level <= level ? HYSTERESIS : 1)) break;
        triangles += more;
        levels.set(region, level);
      }
    for (const region of seen) {
      region.setLevel(levels.get(region));
      region.build(this.shading);
      region.mesh.material = this.shading === 'clay' ? this.clay : this.painted;
    }
    this.drawn = triangles;
  }

  /** Middles of the blocks' surfaces, world, and how many triangles each has. */
  middles() {
    return [...this.regions.values()].flatMap(({ blocks }) => [...blocks.values()].map(({ middle, indices }) => ({ point: middle.clone(), triangles: indices[0].length / 3 })));
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
