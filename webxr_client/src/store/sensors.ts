/** Sensors of the open recording, where it has several: names, colours, and which are hidden here. */
import { computed, signal } from '@preact/signals';
import { SAFE_COLORS } from '../common/colors';
import { state } from './state';

export interface ListedSensor {
  readonly number: number;
  readonly name: string;
  /** Words for its kind, or empty. */
  readonly kind: string;
  readonly color: string;
}

const KINDS = {
  depth: 'depth camera',
  spinning: 'lidar',
  'solid-state': 'lidar',
  radar: 'radar',
  unknown: '',
} as const;

/** None in a recording of one sensor. */
export const sensors = computed<readonly ListedSensor[]>(() =>
  (state.sequence.value?.sensors ?? []).map(({ name, type }, number) => {
    return { number, name, kind: KINDS[type], color: SAFE_COLORS[number % SAFE_COLORS.length]! };
  }),
);

/** Numbers of the sensors with points that are neither shown, nor met by rays, nor painted. */
export const hiddenSensors = signal<ReadonlySet<number>>(new Set());

export function showSensor(number: number, on: boolean): void {
  const hidden = new Set(hiddenSensors.peek());
  if (on) hidden.delete(number);
  else hidden.add(number);
  hiddenSensors.value = hidden;
}

/** Whether frames come as depth images. */
export const hasDepth = computed(() => {
  const info = state.sequence.value;
  return info !== null && [info, ...info.sensors].some(({ lattice }) => lattice !== null);
});

/** Fields that points can be coloured by. */
export const colourFields = computed<readonly string[]>(() => {
  const fields = state.sequence.value?.fields ?? [];
  return sensors.value.length > 0 ? [...fields, 'sensor'] : fields;
});

export function colourBySensor(on: boolean): void {
  state.view.value = { ...state.view.peek(), color: on ? 'sensor' : 'rgb' };
}
