/** Sample of a pointing device: the mouse, a controller, a hand. */
import type { Vec } from '../cloud/pick';

/** Local coordinates of the recording, metres; `direction` of unit length. */
export interface PointerSample {
  readonly origin: Vec;
  readonly direction: Vec;
}
