/** Work that the server does once on its machine before the object tool can be used. */
import { state } from '../store/state';

/** Text of how far it is; null: the tool can be used. */
export function preparation(): string | null {
  const share = state.compiling.value.get('objects');
  return share === undefined ? null : `Preparing the object tool: ${Math.floor(share * 100)} %`;
}
