import { Matrix4, Vector3 } from 'three';
import { describe, expect, it, vi } from 'vitest';
import { Poses } from './poses';

type Space = XRSpace & { x: number; seen: boolean; guessed?: boolean };
const space = (x: number): Space => ({ x, seen: true }) as unknown as Space;
const BASE = {} as unknown as XRReferenceSpace;

/** A frame in which each space lies at its own x; `fills`: the browser has `fillPoses`. */
function frameWith(fills: boolean): XRFrame {
  const matrix = ({ x }: Space): number[] => new Matrix4().makeTranslation(x, 0, 0).toArray();
  const getPose = (one: Space): unknown => {
    const transform = { matrix: Float32Array.from(matrix(one)) };
    return one.seen ? { transform, emulatedPosition: one.guessed === true } : null;
  };
  const fillPoses = (spaces: Space[], _: unknown, out: Float32Array): boolean => {
    spaces.forEach((one, i) => {
      if (one.seen) out.set(matrix(one), 16 * i);
      else out.fill(NaN, 16 * i, 16 * i + 16);
    });
    return spaces.every((one) => one.seen);
  };
  return (fills ? { getPose, fillPoses } : { getPose }) as unknown as XRFrame;
}

describe.each([true, false])('poses of a frame, fillPoses there: %s', (fills) => {
  const out = new Matrix4();
  const x = (): number => new Vector3().setFromMatrixPosition(out).x;

  it('are those of head, rays and grips, whoever comes and goes', () => {
    const poses = new Poses(space(1));
    const right = { targetRaySpace: space(2), gripSpace: space(3) } as unknown as XRInputSource;
    const left = { targetRaySpace: space(4) } as unknown as XRInputSource;
    const [one, two] = [poses.add(right), poses.add(left)];
    poses.read(frameWith(fills), BASE);
    expect(poses.head(out) && x()).toBe(1);
    expect(poses.ray(one, out) && x()).toBe(2);
    expect(poses.grip(one, out) && x()).toBe(3);
    expect(poses.ray(two, out) && x()).toBe(4);
    expect(poses.grip(two, out)).toBe(false);
    poses.remove(one);
    poses.read(frameWith(fills), BASE);
    expect(poses.ray(one, out)).toBe(false);
    expect(poses.ray(two, out) && x()).toBe(4);
    expect(poses.add(right)).toBe(one);
    for (let more = 2; more < 8; more++) expect(poses.add(left)).toBe(more);
    expect(poses.add(left)).toBe(-1);
  });

  it('tell of a guessed position, asked of one input alone', () => {
    const poses = new Poses(space(1));
    const [known, guess] = [space(2), Object.assign(space(3), { guessed: true })];
    const one = poses.add({ targetRaySpace: known } as unknown as XRInputSource);
    const two = poses.add({ targetRaySpace: guess } as unknown as XRInputSource);
    const frame = frameWith(fills);
    poses.read(frame, BASE);
    const getPoseSpy = vi.spyOn(frame, 'getPose');
    const isGuessed = (input: number): boolean => poses.guessed(input, frame, BASE);
    // A device that never knew a place cannot say that this one is worse.
    expect([isGuessed(two), isGuessed(one), isGuessed(two)]).toEqual([false, false, true]);
    expect(getPoseSpy.mock.calls.map(([of]) => of)).toEqual([guess, known, guess]);
    poses.remove(two);
    expect(isGuessed(two)).toBe(false);
  });

  it('are none while tracking is lost, and come back', () => {
    const head = space(1);
    const poses = new Poses(head);
    head.seen = false;
    poses.read(frameWith(fills), BASE);
    expect(poses.head(out)).toBe(false);
    head.seen = true;
    poses.read(frameWith(fills), BASE);
    expect(poses.head(out) && x()).toBe(1);
  });
});
