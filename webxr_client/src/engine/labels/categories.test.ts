import { afterEach, expect, test, vi } from 'vitest';
import type { Label, SequenceInfo } from '../../protocol/messages';
import { state } from '../../store/state';
import { categoriesSelected, categoryChoices, loadCategories } from './categories';

function answering(selected: boolean, names: readonly string[]): void {
  vi.stubGlobal('document', { baseURI: 'http://host/' });
  vi.stubGlobal('fetch', () => Promise.resolve(Response.json({ selected, names })));
}
state.sequence.value = { id: 'street' } as SequenceInfo;
state.palette.value = [
  { id: 1, category: 'oak' },
  { id: 2, category: '' },
] as Label[];
afterEach(() => void vi.unstubAllGlobals());

test('of a selection nothing else is offered, also not what is in use', async () => {
  answering(true, ['car', 'tree']);
  await loadCategories();
  expect([categoriesSelected.value, categoryChoices.value]).toEqual([true, ['car', 'tree']]);
});

test('without one what is in use comes before the rest of the workspace', async () => {
  answering(false, ['car', 'oak']);
  await loadCategories();
  expect([categoriesSelected.value, categoryChoices.value]).toEqual([false, ['oak', 'car']]);
});
