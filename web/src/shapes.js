// Lines and the camera's pyramid, as both pages draw them.
import * as THREE from 'three';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { LineSegments2 } from 'three/examples/jsm/lines/LineSegments2.js';
import { LineSegmentsGeometry } from 'three/examples/jsm/lines/LineSegmentsGeometry.js';

/** Lines of a width in pixels; `points` holds pairs of ends, x y z each. */
export function segments(points, name, width) {
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
export function chain(count, point, joined = () => true) {
  const ends = [];
  for (let i = 0; i + 1 < count; i++) if (joined(i)) ends.push(...point(i), ...point(i + 1));
  return ends;
}

/** The camera as a pyramid of its field of view, `depth` metres long. */
export function cameraMarker({ width, height, fx, fy, cx, cy }, depth) {
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
