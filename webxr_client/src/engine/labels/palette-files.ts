/** Palettes from templates and files, and as a file; the order of the palette. */
import { signal } from '@preact/signals';
import { saveFile } from '../../net/files';
import { api } from '../../net/rest';
import type { AddedLabels, Palette } from '../../protocol/values';
import { notify, state } from '../../store/state';
import { attempt, openPath } from '../recordings/recordings';
import { showAtOnce } from './labels';

export interface Template {
  readonly name: string;
  /** Number of its labels. */
  readonly labels: number;
}

/** Palettes of well-known datasets; filled by `loadTemplates`. */
export const templates = signal<readonly Template[]>([]);

export const loadTemplates = (): Promise<void> =>
  attempt('The templates did not load', async () => {
    const found = await api<Record<string, Palette>>('GET', 'templates');
    templates.value = Object.entries(found).map(([name, { labels }]) => ({
      name,
      labels: labels.length,
    }));
  });

/** Add the labels of a template that are not there yet. */
export const addTemplate = (template: string): Promise<void> =>
  attempt('The labels were not added', () => add({ template }));

async function add(body: unknown): Promise<void> {
  const { added } = await api<AddedLabels>('POST', openPath('palette'), body);
  const title = added.length === 0 ? 'All of these labels exist already' : 'Labels added';
  notify(added.length === 0 ? 'info' : 'success', title, added.slice(0, 8).join(', '));
}

/** The labels of a `palette.json`, of an export's or of a palette saved here. */
export function labelsOf(text: string): readonly unknown[] {
  let found: unknown;
  try {
    found = JSON.parse(text);
  } catch {
    throw new Error('Expected a palette file (JSON), got a file that is not JSON.');
  }
  const labels = (found as Partial<Palette> | null)?.labels;
  if (!Array.isArray(labels) || labels.length === 0) {
    throw new Error('Expected a palette file with "labels", got none.');
  }
  return labels as unknown[];
}

/** Choose a palette file, and add its labels. */
export function pickPalette(): void {
  const input = document.createElement('input');
  input.type = 'file';
  input.accept = '.json,application/json';
  input.onchange = () => {
    const file = input.files?.[0];
    if (!file) return;
    void attempt('The palette was not added', async () =>
      add({ labels: labelsOf(await file.text()) }),
    );
  };
  input.click();
}

/** Download the palette. */
export const savePalette = (): Promise<void> =>
  attempt('The palette was not saved', async () => {
    const palette = await api('GET', openPath('palette'));
    saveFile(`${state.sequence.peek()?.name ?? 'recording'} palette.json`, palette);
  });

/** Put the palette in an order of label ids; the server keeps it. */
export function arrangeLabels(order: readonly number[]): Promise<void> {
  const place = new Map(order.map((id, index) => [id, index]));
  const at = (id: number): number => place.get(id) ?? order.length;
  const next = [...state.palette.peek()].sort((a, b) => at(a.id) - at(b.id));
  return showAtOnce(next, 'The order was not saved', () =>
    api('PUT', openPath('palette/order'), { labels: order }),
  );
}
