/** Categories for labels of the open recording: the selection of its project, or all. */
import { computed, signal } from '@preact/signals';
import { api } from '../../net/rest';
import type { OfferedCategories } from '../../protocol/values';
import { state } from '../../store/state';
import { attempt, sequencePath } from '../recordings/recordings';

const ALL: OfferedCategories = { selected: false, names: [] };
const offered = signal(ALL);

/** True: labels get only these categories. */
export const categoriesSelected = computed(() => offered.value.selected);

/** Selected categories; without a selection, categories in use, then the workspace's. */
export const categoryChoices = computed<readonly string[]>(() => {
  const { selected, names } = offered.value;
  if (selected) return names;
  const used = state.palette.value.map(({ category }) => category).filter(Boolean);
  return [...new Set([...used, ...names])];
});

/** Load the categories that the open recording's project has selected. */
export async function loadCategories(): Promise<void> {
  const of = state.sequence.peek()?.id;
  offered.value = ALL;
  if (of === undefined) return;
  await attempt('The categories did not load', async () => {
    const found = await api<OfferedCategories>('GET', `${sequencePath(of)}/categories`);
    if (state.sequence.peek()?.id === of) offered.value = found;
  });
}
