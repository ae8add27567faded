/** Buffers of our own that three draws from. */
import { BufferGeometry, GLBufferAttribute, InterleavedBufferAttribute, Sphere } from 'three';
import type { InterleavedBuffer, Matrix4 } from 'three';
import { STRIDE } from '../../net/chunk/segment';
import { normalColours } from '../points/normals';
import type { Piece } from '../points/piece';

/** Offset of the colours in a vertex. */
const COLOURS = 6;
/** Colours by normals, of pieces that were shown so; a piece's points never change. */
const normals = new WeakMap<Piece, { readonly room: Matrix4; readonly colours: Uint8Array }>();

/** Vertices (12 bytes) and labels (uint16) of up to `capacity` points. */
export class PointBuffers {
  readonly vertices: WebGLBuffer;
  readonly labels: WebGLBuffer;

  constructor(
    readonly gl: WebGL2RenderingContext,
    readonly capacity: number,
  ) {
    this.vertices = this.allocate(capacity * STRIDE);
    this.labels = this.allocate(capacity * 2);
  }

  private allocate(bytes: number): WebGLBuffer {
    const { gl } = this;
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, bytes, gl.DYNAMIC_DRAW);
    return buffer;
  }

  /** Write `count` points, from a piece on; the points of its segment are contiguous. */
  writeVertices(first: number, { segment, words }: Piece, count: number): void {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.vertices);
    const { byteOffset } = words;
    gl.bufferSubData(gl.ARRAY_BUFFER, first * STRIDE, segment!, byteOffset, count * STRIDE);
  }

  /** Points of pieces that lie together in a segment, in the colours of their normals. */
  writeNormals(first: number, pieces: readonly Piece[], room: Matrix4): void {
    const { gl } = this;
    const { segment, words } = pieces[0]!;
    const colours = coloursOf(pieces, room);
    const from = words.byteOffset;
    const vertices = segment!.slice(from, from + (colours.length / 3) * STRIDE);
    for (let at = COLOURS, i = 0; i < colours.length; at += STRIDE) {
      vertices[at] = colours[i++]!;
      vertices[at + 1] = colours[i++]!;
      vertices[at + 2] = colours[i++]!;
    }
    gl.bindBuffer(gl.ARRAY_BUFFER, this.vertices);
    gl.bufferSubData(gl.ARRAY_BUFFER, first * STRIDE, vertices);
  }

  /** The first `count` values, to the start of the labels. */
  writeLabels(values: Uint16Array, count: number): void {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.labels);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, values, 0, count);
  }

  geometry(): BufferGeometry {
    const { gl, capacity } = this;
    const geometry = new BufferGeometry();
    const words = interleaved(this.vertices, gl.UNSIGNED_SHORT, 2, 6, capacity);
    const bytes = interleaved(this.vertices, gl.UNSIGNED_BYTE, 1, 12, capacity);
    const ids = interleaved(this.labels, gl.UNSIGNED_SHORT, 2, 1, capacity);
    geometry.setAttribute('quantised', new InterleavedBufferAttribute(words, 3, 0));
    geometry.setAttribute('colour', new InterleavedBufferAttribute(bytes, 4, 6, true));
    geometry.setAttribute('stamp', new InterleavedBufferAttribute(words, 1, 5));
    geometry.setAttribute('label', new InterleavedBufferAttribute(ids, 1, 0));
    geometry.boundingSphere = new Sphere();
    geometry.setDrawRange(0, 0);
    return geometry;
  }

  dispose(): void {
    this.gl.deleteBuffer(this.vertices);
    this.gl.deleteBuffer(this.labels);
  }
}

function coloursOf(pieces: readonly Piece[], room: Matrix4): Uint8Array {
  const [first] = pieces;
  const known = normals.get(first!);
  if (known?.room === room) return known.colours;
  const colours = normalColours(pieces, room);
  normals.set(first!, { room, colours });
  return colours;
}

/**
 * A view of our own GL buffer that three takes for the data of an interleaved attribute.
 * three's `GLBufferAttribute` knows no stride and its `InterleavedBuffer` insists on a second
 * copy of the points in memory; together they provide all that it needs.
 */
function interleaved(
  buffer: WebGLBuffer,
  type: GLenum,
  bytes: 1 | 2,
  stride: number,
  count: number,
): InterleavedBuffer {
  const data = new GLBufferAttribute(buffer, type, stride, bytes, count);
  return Object.assign(data, { stride, array: [] }) as unknown as InterleavedBuffer;
}
