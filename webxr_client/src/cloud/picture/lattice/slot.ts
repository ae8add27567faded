/** A depth camera's frame: its image in textures, drawn as points and as a surface. */
import { BufferAttribute, BufferGeometry, Group, Matrix4, Mesh, Points, RawShaderMaterial, Sphere, Vector2 } from 'three'; // prettier-ignore
import type { WebGLRenderer } from 'three';
import { free } from '../../../common/free';
import { SLANT, sidesOf } from '../../../net/depth/grid';
import { bandsOf, type Band } from '../../../net/depth/lattice';
import type { Lattice } from '../../../protocol/messages';
import type { CloudFrame } from '../../points/frame';
import { STEEPEST } from './shader';
import { LatticeTextures } from './textures';
import { cloudMaterial, type Placement, type PointUniforms } from '../material';
import { Slot } from '../slots/slot';

export class LatticeSlot extends Slot {
  readonly object = new Group();
  private readonly textures: LatticeTextures;
  private readonly bands: readonly Band[];
  /** Columns, rows, and pixels between them; of the points, and of the surface. */
  private readonly grids = new Int32Array(8);
  private readonly points: Points<BufferGeometry, RawShaderMaterial>;
  private readonly surface: Mesh<BufferGeometry, RawShaderMaterial>;

  constructor(
    renderer: WebGLRenderer,
    private readonly lattice: Lattice,
    uniforms: PointUniforms,
    placement: Placement | null,
  ) {
    super(uniforms, lattice.width * lattice.height);
    this.bands = bandsOf(lattice);
    this.textures = new LatticeTextures(renderer, lattice);
    const own = {
      ...this.textures.uniforms,
      grids: { value: this.grids },
      rays: { value: raysOf(lattice) },
      steps: { value: stepsOf(lattice) },
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

  protected uploadPoints(frame: CloudFrame): void {
    this.textures.writeImage(frame, this.normals);
    this.uploaded = frame.loaded;
  }

  protected show({ pieces }: CloudFrame, points: number): void {
    let last = 0;
    while (last + 1 < pieces.length && pieces[last + 1]!.first < points) last += 1;
    const { bands, grids } = this;
    this.setGrid(0, bands[last]!);
    // A surface is of whole levels: a level that has come in part has gaps.
    let whole = last;
    while (whole > 0 && bands[whole + 1]?.level === bands[whole]!.level) whole -= 1;
    this.setGrid(4, bands[whole]!);
    this.points.geometry.setDrawRange(0, points > 0 ? grids[0]! * grids[1]! : 0);
    this.connect();
  }

  /** Give the surface the triangles of its grid, which are made when a surface is first drawn. */
  private connect(): void {
    const { grids, surface } = this;
    if (!surface.visible) return;
    surface.geometry = this.drawn > 0 ? trianglesOf(grids[4]!, grids[5]!) : NOTHING;
  }

  private setGrid(at: number, { down, across, half, vertical }: Band): void {
    const { width, height } = this.lattice;
    const x = vertical || half === 0 ? across : half;
    const y = vertical ? half : down;
    this.grids.set([Math.ceil(width / x), Math.ceil(height / y), x, y], at);
  }

  protected writeLabels(frame: CloudFrame): void {
    this.textures.writeLabels(frame, this.labels);
  }

  dispose(): void {
    this.object.removeFromParent();
    free(this.points);
    free(this.surface);
    this.textures.dispose();
  }
}

/** `T_local_pixel`: local metres of 1, a depth, and the depth times column and row. */
export function raysOf(lattice: Lattice): Matrix4 {
  const { axis, sign, eye, unit, tangent, pitch } = lattice;
  const [a, b] = sidesOf(lattice);
  const rays = new Matrix4();
  const e = rays.elements.fill(0);
  e.splice(0, 3, ...eye);
  e[4 + axis] = sign * unit;
  e[4 + a] = unit * tangent[0];
  e[4 + b] = unit * tangent[1];
  e[8 + a] = unit * pitch[0];
  e[12 + b] = unit * pitch[1];
  e[3] = 1;
  return rays;
}

/** At one unit of depth: metres between neighbours, and units between them on the steepest surface. */
export function stepsOf({ unit, pitch }: Lattice): Vector2 {
  const apart = Math.sqrt(pitch[0] * pitch[1]);
  return new Vector2(SLANT * apart * unit, STEEPEST * apart);
}

/** Cells along each side of a tile: triangles that follow one another share corners. */
const TILE = 16;
/** Most grids with cached triangles: all levels of one lattice. */
const MOST_GRIDS = 16;
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
