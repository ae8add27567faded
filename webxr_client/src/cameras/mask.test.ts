import { describe, expect, it } from 'vitest';
import { depthCamera, drawDepth } from './depth-picture';
import { Lens } from './lens';
import { PaintedMask } from './mask';

function rows({ width, height, pixels }: PaintedMask): string[] {
  return Array.from({ length: height }, (_, row) =>
    [...pixels.subarray(row * width, (row + 1) * width)].map((on) => (on ? '#' : '.')).join(''),
  );
}

describe('pixels painted in a picture', () => {
  it('are those whose middle the brush has passed over, also between two samples', () => {
    const mask = new PaintedMask(8, 5);
    mask.brush([[2, 2.5], [6, 2.5]], 1.2); // prettier-ignore
    expect(rows(mask)).toEqual(['........', '.######.', '.######.', '.######.', '........']);
  });

  it('are a disc where the brush was pressed once, cut at the edge of the picture', () => {
    const mask = new PaintedMask(4, 4);
    mask.brush([[0, 0]], 1.6);
    expect(rows(mask)).toEqual(['##..', '#...', '....', '....']);
  });

  it('are inside a polygon, which may cross itself', () => {
    const triangle = new PaintedMask(6, 4);
    triangle.polygon([[0, 0], [6, 0], [0, 4]]); // prettier-ignore
    expect(rows(triangle)).toEqual(['#####.', '####..', '##....', '#.....']);
    const bow = new PaintedMask(6, 4);
    bow.polygon([[0, 0], [6, 4], [6, 0], [0, 4]]); // prettier-ignore
    expect(rows(bow)).toEqual(['#....#', '##..##', '##..##', '#....#']);
    const wide = new PaintedMask(3, 2);
    wide.polygon([[-9, -9], [9, -9], [9, 9], [-9, 9]]); // prettier-ignore
    expect(rows(wide)).toEqual(['###', '###']);
  });

  it('are a NumPy array of the size of the picture', async () => {
    const mask = new PaintedMask(3, 2);
    mask.polygon([[1, 0], [2, 0], [2, 2], [1, 2]]); // prettier-ignore
    const bytes = new Uint8Array(await mask.npy().arrayBuffer());
    const [head, data] = [bytes.subarray(0, 128), bytes.subarray(128)];
    expect([...head.subarray(0, 10)]).toEqual([0x93, 78, 85, 77, 80, 89, 1, 0, 118, 0]);
    expect(new TextDecoder().decode(head.subarray(10))).toMatch(/'shape': \(2, 3\), } +\n$/);
    expect([...data]).toEqual([0, 1, 0, 0, 1, 0]);
  });
});

describe('the picture of a depth camera', () => {
  const lattice = { width: 4, height: 2, axis: 2, sign: 1, tangent: [-0.6, 0.2], pitch: [0.4, -0.4], eye: [1, 0, 0], unit: 0.001 } as const; // prettier-ignore

  // A quarter turn around z, and a step aside.
  const turned = [0, -1, 0, 3, 1, 0, 0, 0, 0, 0, 1, 0.5, 0, 0, 0, 1];

  it.each([null, turned])(
    'has each point in the pixel that measured it, with mount %j',
    (mount) => {
      const shift: [number, number, number] = [5, 0, 0];
      const image = { sensor: 0, lattice: { ...lattice, tangent: [-0.6, 0.2], pitch: [0.4, -0.4], eye: [1, 0, 0] }, mount } as never; // prettier-ignore
      const lens = Lens.of(depthCamera(image, { shift, sensors: [] }), shift)!;
      for (const [column, row] of [[0, 0], [3, 1], [2, 0]] as const) {
      const [x, y] = [1 + 2 * (-0.6 + 0.4 * column), 2 * (0.2 - 0.4 * row)];
      expect(mount ? lens.project(3 - y, x, 2.5) : lens.project(x, y, 2)).toBe(true);
      expect([...lens.at].map((part) => Math.floor(part))).toEqual([column, row, 2]);
    } // prettier-ignore
    },
  );

  it('has the colours of a picture with half of its chroma, or greys by depth', () => {
    const into = { data: new Uint8ClampedArray(32) } as ImageData;
    const depths = Uint16Array.of(0, 1000, 2000, 4000, 1, 1, 1, 1);
    const luma = [0, 50, 100, 150, 200, 210, 220, 230];
    const bytes = Uint8Array.from([...luma, 128, 228, 128, 128]);
    const planes = Int32Array.of(0, 4, 17, 1, 8, 2, 34, 1, 10, 2, 34, 1);
    const image = { lattice: { ...lattice, tangent: [0, 0], pitch: [1, 1], eye: [0, 0, 0] }, depths } as const; // prettier-ignore
    drawDepth({ ...image, colours: { bytes, planes, luma: true, step: 1 } } as never, into);
    expect([...into.data.subarray(4, 8)]).toEqual([50, 50, 50, 255]);
    expect([...into.data.subarray(28)]).toEqual([230, 196, 255, 255]);
    drawDepth({ ...image, colours: null } as never, into);
    expect(into.data[3]).toBe(0);
    expect(into.data[4]).toBeGreaterThan(into.data[12]!);
  });
});
