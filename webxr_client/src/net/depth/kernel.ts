/** The WebAssembly that decodes bands (`assembly/band.ts`). */
import code from '../../../assembly/band.ts?assembly';

const bytes = Uint8Array.from(atob(code), (char) => char.charCodeAt(0));

/** Whether this browser runs WebAssembly; without it frames come as points. */
export const supported = WebAssembly.validate(bytes);

const PAGE = 65536;
/** Bytes of the widest numbers. */
const ALIGNMENT = 4;

type Numbers = Uint8Array | Uint16Array | Uint32Array;

/** Lay arrays into a memory for the kernel, where their addresses are their offsets. */
export function inOneMemory<T extends Record<string, Numbers>>(
  arrays: T,
): { memory: WebAssembly.Memory; views: T } {
  let end = 0;
  const placed = Object.entries(arrays).map(([name, array]) => {
    const address = end;
    end = Math.ceil((address + array.byteLength) / ALIGNMENT) * ALIGNMENT;
    return { name, array, address };
  });
  const memory = new WebAssembly.Memory({ initial: Math.ceil(end / PAGE) });
  const views = placed.map(({ name, array, address }) => {
    const Kind = array.constructor as new (...given: [ArrayBuffer, number, number]) => Numbers;
    const view = new Kind(memory.buffer, address, array.length);
    view.set(array);
    return [name, view];
  });
  return { memory, views: Object.fromEntries(views) as T };
}

/** `decode`, with addresses in `memory`. */
export type Decode = (...given: number[]) => number;

let compiled: WebAssembly.Module | null = null;

export function instantiate(memory: WebAssembly.Memory): Decode {
  compiled ??= new WebAssembly.Module(bytes);
  const { exports } = new WebAssembly.Instance(compiled, { env: { memory } });
  return exports['decode'] as Decode;
}
