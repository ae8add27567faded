/** The image of one depth camera in textures, drawn as points and as a surface. */
import { BufferAttribute, BufferGeometry, Group, Matrix4, Mesh, Points, RawShaderMaterial, Sphere, Vector2 } from 'three'; // prettier-ignore
import type { WebGLRenderer } from 'three';
import { free } from '../../../common/free';
import type { DepthImage } from '../../../net/chunk/segment';
import { raysOf, SLANT } from '../../../net/depth/grid';
import { bandsOf, type Band } from '../../../net/depth/lattice';
import type { Lattice } from '../../../protocol/messages';
import type { CloudFrame } from '../../points/frame';
import { STEEPEST } from './shader';
import { LatticeTextures } from './textures';
import { cloudMaterial, type Placement, type PointUniforms } from '../material';
import type { Part } from '../slots/part';

export class LatticePart implements Part {
  readonly object = new Group();
  private readonly textures: LatticeTextures;
  private readonly bands: readonly Band[];
  /** Columns, rows, and pixels between them; of the points, and of the surface. */
  private readonly grids = new Int32Array(8);
  private readonly rays = new Matrix4();
  private readonly sensor: number;
  private readonly lattice: Lattice;
  /** Its chunks on screen. */
  private chunks = 0;
  private readonly points: Points<BufferGeometry, RawShaderMaterial>;
  private readonly surface: Mesh<BufferGeometry, RawShaderMaterial>;

  constructor(
    renderer: WebGLRenderer,
    { sensor, lattice }: DepthImage,
    uniforms: PointUniforms,
    placement: Placement | null,
  ) {
    this.sensor = sensor;
    this.lattice = lattice;
    this.bands = bandsOf(lattice);
    this.textures = new LatticeTextures(renderer, lattice);
    const own = {
      ...this.textures.uniforms,
      grids: { value: this.grids },
      rays: { value: this.rays },
      steps: { value: stepsOf(lattice) },
      sensor: { value: sensor },
    };
    const points = cloudMaterial(uniforms, own, { LATTICE: 1 }, placement);
    const surface = cloudMaterial(uniforms, own, { LATTICE: 1, SURFACE: 1 }, placement);
    this.points = new Points(new BufferGeometry(), points);
    this.points.geometry.boundingSphere = new Sphere();
    this.surface = new Mesh(NOTHING, surface);
    for (const part of [this.points, this.surface]) {
      part.frustumCulled = part.matrixAutoUpdate = false;
      this.object.add(part);
    }
    this.object.matrixAutoUpdate = false;
    this.showSurface(placement === null && uniforms.surface);
  }

  showSurface(on: boolean): void {
    this.surface.visible = on;
    this.connect();
  }

  uploadPoints(frame: CloudFrame, _: number, normals: Matrix4 | null): void {
    const image = frame.imageOf(this.sensor)!;
    this.rays.copy(raysMatrix(image));
    this.textures.writeImage(frame, image, normals);
  }

  show({ pieces }: CloudFrame, points: number): void {
    this.chunks = 0;
    for (let i = 0; i < pieces.length && pieces[i]!.first < points; i++) {
      if (pieces[i]!.sensor === this.sensor) this.chunks += 1;
    }
    const { bands, grids } = this;
    const last = Math.max(0, this.chunks - 1);
    this.setGrid(0, bands[last]!);
    // A surface is of whole levels: a level that has come in part has gaps.
    let whole = last;
    while (whole > 0 && bands[whole + 1]?.level === bands[whole]!.level) whole -= 1;
    this.setGrid(4, bands[whole]!);
    this.points.geometry.setDrawRange(0, this.chunks > 0 ? grids[0]! * grids[1]! : 0);
    this.connect();
  }

  /** Give the surface the triangles of its grid, which are made when a surface is first drawn. */
  private connect(): void {
    const { grids, surface } = this;
    if (!surface.visible) return;
    surface.geometry = this.chunks > 0 ? trianglesOf(grids[4]!, grids[5]!) : NOTHING;
  }

  private setGrid(at: number, { down, across, half, vertical }: Band): void {
    const { width, height } = this.lattice;
    const x = vertical || half === 0 ? across : half;
    const y = vertical ? half : down;
    this.grids.set([Math.ceil(width / x), Math.ceil(height / y), x, y], at);
  }

  writeLabels(frame: CloudFrame, labels: Uint16Array, _: number, all: boolean): void {
    this.textures.writeLabels(frame, this.sensor, labels, all);
  }

  dispose(): void {
    free(this.points);
    free(this.surface);
    this.textures.dispose();
  }
}

/** `T_local_pixel` of a camera, see `raysOf`. */
export function raysMatrix(image: DepthImage): Matrix4 {
  return new Matrix4().set(...(raysOf(image) as Parameters<Matrix4['set']>));
}

/** At one unit of depth: metres between neighbours, and units between them on the steepest surface. */
export function stepsOf({ unit, pitch }: Lattice): Vector2 {
  const apart = Math.sqrt(pitch[0] * pitch[1]);
  return new Vector2(SLANT * apart * unit, STEEPEST * apart);
}

/** Cells along each side of a tile: triangles that follow one another share corners. */
const TILE = 16;
/** Most grids with cached triangles: all levels of four lattices. */
const MOST_GRIDS = 64;
const NOTHING = new BufferGeometry();
NOTHING.boundingSphere = new Sphere();
const made = new Map<string, BufferGeometry>();

/** Two triangles for each cell of a grid, tile by tile; each pixel is one vertex. */
export function trianglesOf(columns: number, rows: number): BufferGeometry {
  const key = `${columns} ${rows}`;
  const known = made.get(key);
  if (known) return known;
  const corners = [0, columns, 1, 1, columns, columns + 1];
  const indices = new Uint32Array(
    corners.length * Math.max(0, columns - 1) * Math.max(0, rows - 1),
  );
  let i = 0;
  for (let top = 0; top < rows - 1; top += TILE) {
    for (let left = 0; left < columns - 1; left += TILE) {
      for (let row = top; row < Math.min(top + TILE, rows - 1); row++) {
        for (let column = left; column < Math.min(left + TILE, columns - 1); column++) {
          const corner = row * columns + column;
          for (let k = 0; k < corners.length; k++) indices[i++] = corner + corners[k]!;
        }
      }
    }
  }
  const geometry = new BufferGeometry();
  geometry.setIndex(new BufferAttribute(indices, 1));
  geometry.boundingSphere = new Sphere();
  const [oldest] = made;
  if (oldest && made.size >= MOST_GRIDS) {
    oldest[1].dispose();
    made.delete(oldest[0]);
  }
  made.set(key, geometry);
  return geometry;
}
