// What the program has put into the page: JSON and base64 buffers in script elements.
import { decodeIndices, decodeVertices, decoderReady } from './decode.js';

function bytesOf(id) {
  const element = document.getElementById(id);
  if (!element) return null;
  const binary = atob(element.textContent);
  element.remove(); // megabytes of text that nobody reads again
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

function floatsOf(id) {
  const bytes = bytesOf(id);
  return bytes && new Float32Array(bytes.buffer);
}

/** Columns by name; what was not measured is NaN. */
class FrameTable {
  constructor({ rows, stride, columns }, values) {
    this.rows = rows;
    this.stride = stride;
    this.columns = new Map(columns.map((name, i) => [name, values.subarray(i * rows, (i + 1) * rows)]));
  }

  has(name) {
    return this.columns.has(name);
  }

  column(name) {
    return this.columns.get(name);
  }

  at(name, row) {
    return this.columns.get(name)[row];
  }

  position(row) {
    return ['tx', 'ty', 'tz'].map((name) => this.at(name, row));
  }

  quaternion(row) {
    return ['qx', 'qy', 'qz', 'qw'].map((name) => this.at(name, row));
  }

  truePosition(row) {
    return ['true_tx', 'true_ty', 'true_tz'].map((name) => this.at(name, row));
  }
}

/** Four components a vertex; see PackedMesh in apps/plumbline/view/packed_mesh.h. */
async function readMesh(header) {
  if (!header) return null;
  await decoderReady;
  const mesh = { ...header };
  const view = (id, Type) => decodeVertices(bytesOf(id), header.vertices, Type);
  mesh.positions = view('mesh-positions', Uint16Array);
  mesh.normals = view('mesh-normals', Int8Array);
  mesh.colors = view('mesh-colors', Uint8Array);
  mesh.errors = view('mesh-errors', Uint8Array);
  mesh.indices = decodeIndices(bytesOf('mesh-indices'), header.triangles);
  return mesh;
}

export async function readReport() {
  const report = JSON.parse(document.getElementById('report').textContent);
  const frames = report.frames ? new FrameTable(report.frames, floatsOf('frames')) : null;
  return { ...report, frames, truePath: floatsOf('true-path'), path: floatsOf('path'), mesh: await readMesh(report.mesh) };
}
