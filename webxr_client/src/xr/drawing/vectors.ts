/** Sums with vectors that hand no number on: three's own give back lengths, which V8 boxes. */
import type { Matrix4, Vector3 } from 'three';

/** A direction turned by a matrix, of unit length; `from` and `out` may be the same. */
export function turnBy({ elements: m }: Matrix4, from: Vector3, out: Vector3): Vector3 {
  const x = m[0] * from.x + m[4] * from.y + m[8] * from.z;
  const y = m[1] * from.x + m[5] * from.y + m[9] * from.z;
  const z = m[2] * from.x + m[6] * from.y + m[10] * from.z;
  const length = Math.max(1e-12, Math.sqrt(x * x + y * y + z * z));
  out.x = x / length;
  out.y = y / length;
  out.z = z / length;
  return out;
}

/** Whether two places are nearer to each other than `limit`; never where one is not a number. */
export function within(a: Vector3, b: Vector3, limit: number): boolean {
  const x = a.x - b.x;
  const y = a.y - b.y;
  const z = a.z - b.z;
  return x * x + y * y + z * z < limit * limit;
}
