// Buffers as meshoptimizer's encoders leave them; see PackedMesh in apps/plumbline/view/packed_mesh.h.
import { MeshoptDecoder } from 'three/examples/jsm/libs/meshopt_decoder.module.js';

export const decoderReady = MeshoptDecoder.ready;

/** Four components of `Type` a vertex; null where there is nothing. */
export function decodeVertices(packed, count, Type) {
  if (!packed?.length) return null;
  const values = new Type(4 * count);
  MeshoptDecoder.decodeVertexBuffer(new Uint8Array(values.buffer), count, 4 * Type.BYTES_PER_ELEMENT, packed);
  return values;
}

/** Three a triangle; null where there is nothing. */
export function decodeIndices(packed, triangles) {
  if (!packed?.length) return null;
  const indices = new Uint32Array(3 * triangles);
  MeshoptDecoder.decodeIndexBuffer(new Uint8Array(indices.buffer), indices.length, 4, packed);
  return indices;
}
