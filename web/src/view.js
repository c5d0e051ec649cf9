// Where to stand at first: all of the scene in sight, from the side from which it was recorded.
import * as THREE from 'three';

const SAMPLES = 5000;
const PITCH = (32 * Math.PI) / 180; // looking down

const quantile = (values, share) => values.sort((a, b) => a - b)[Math.floor(share * (values.length - 1))];

/** Points of the mesh, or of the path where there is no mesh. */
function samplePoints({ mesh, frames, path }) {
  const points = [];
  const take = (count, point) => {
    for (let i = 0; i < count; i += Math.max(1, Math.floor(count / SAMPLES))) points.push(point(i));
  };
  if (mesh) take(mesh.vertices, (i) => [0, 1, 2].map((k) => mesh.origin[k] + mesh.step * mesh.positions[4 * i + k]));
  else if (frames) take(frames.rows, (i) => frames.position(i));
  else if (path) take(path.length / 3, (i) => [...path.subarray(3 * i, 3 * i + 3)]);
  return points.length ? points : [[0, 0, 0]];
}

/** Where cameras stood; empty where nobody knows. */
const cameras = ({ frames, path }) => (frames || path?.length ? samplePoints({ frames, path }) : []);

/**
 * Points up to 1.5 times the distance from the path within which most of what matters lies: a surface matters as much as
 * it fills a camera's image, which is by the inverse square of its distance (as MeshRenderer::default_view).
 */
function scannedFromNear(points, path) {
  const some = path.filter((_, i) => i % Math.ceil(path.length / 64) === 0);
  if (!some.length) return points;
  const square = (p) => Math.max(0.25, Math.min(...some.map((c) => (p[0] - c[0]) ** 2 + (p[1] - c[1]) ** 2 + (p[2] - c[2]) ** 2)));
  const squares = points.map(square);
  const ordered = [...squares].sort((a, b) => a - b);
  const all = ordered.reduce((sum, value) => sum + 1 / value, 0);
  let sum = 0;
  const limit = ordered.find((value) => (sum += 1 / value) >= 0.65 * all);
  return points.filter((_, i) => squares[i] <= 2.25 * limit);
}

/** Middle and size of what was scanned from near by, without stray parts: medians, and the distance within which most lies. */
export function sceneExtent(report) {
  return extentOf(scannedFromNear(samplePoints(report), cameras(report)), 0.85);
}

/** Of the cameras alone. */
export function pathExtent({ frames }) {
  return extentOf(samplePoints({ frames }), 1);
}

function extentOf(points, share) {
  const center = [0, 1, 2].map((k) => quantile(points.map((p) => p[k]), 0.5));
  const radius = quantile(points.map((p) => Math.hypot(p[0] - center[0], p[1] - center[1], p[2] - center[2])), share);
  return { center: new THREE.Vector3(...center), radius: Math.max(radius, 0.05) };
}

/** From the middle of the path to that of the scene. */
function fromPath(path, center) {
  const mean = new THREE.Vector3();
  for (let i = 0; i < path.length; i += 3) mean.add(new THREE.Vector3(...path.subarray(i, i + 3)));
  return center.clone().addScaledVector(mean, -3 / path.length);
}

/** Against the mean normal: surfaces face the side from which they were seen. */
function againstNormals({ vertices, normals }) {
  const mean = new THREE.Vector3();
  const step = Math.max(1, Math.floor(vertices / SAMPLES));
  for (let i = 0; i < vertices; i += step) mean.sub(new THREE.Vector3(...normals.subarray(4 * i, 4 * i + 3)));
  return mean.multiplyScalar(step / (127 * vertices));
}

/** The mean direction in which the cameras looked, level; the first camera's where they looked all around. */
function levelDirection({ frames, path, mesh }, center, up) {
  const level = (v) => v.projectOnPlane(up);
  const forward = (row) => level(new THREE.Vector3(0, 0, 1).applyQuaternion(new THREE.Quaternion(...frames.quaternion(row))));
  if (frames) {
    const mean = new THREE.Vector3();
    const step = Math.max(1, Math.floor(frames.rows / 500));
    for (let row = 0; row < frames.rows; row += step) mean.addScaledVector(forward(row), step / frames.rows);
    if (mean.length() > 0.3) return mean.normalize();
    if (forward(0).length() > 0.1) return forward(0).normalize();
  }
  const guess = path?.length ? level(fromPath(path, center)) : mesh?.normals ? level(againstNormals(mesh)) : null;
  if (guess?.length() > 0.05) return guess.normalize();
  const any = Math.abs(up.x) < 0.9 ? new THREE.Vector3(1, 0, 0.6) : new THREE.Vector3(0, 1, 0.6);
  return level(any).normalize();
}

export function overview(report, { center, radius }, fieldOfView) {
  const up = new THREE.Vector3(...report.up);
  const direction = levelDirection(report, center, up).multiplyScalar(Math.cos(PITCH)).addScaledVector(up, -Math.sin(PITCH));
  const half = (fieldOfView * Math.PI) / 360;
  const near = (0.9 * radius) / Math.sin(half);
  // Far enough back to see the whole path too, if that does not make the rest tiny.
  const distance = cameras(report).reduce((farthest, point) => {
    const offset = new THREE.Vector3(...point).sub(center);
    const along = offset.dot(direction);
    const aside = Math.sqrt(Math.max(0, offset.lengthSq() - along * along));
    return Math.max(farthest, Math.min(2 * near, (1.08 * aside) / Math.tan(half) - along));
  }, near);
  return { position: center.clone().addScaledVector(direction, -distance), target: center };
}
