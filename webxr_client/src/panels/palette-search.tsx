/** Above the labels: a search, headings by category, and what the numbers of a row mean. */
import { canGroup, listed, search, shownGroups, wantsGroups } from './palette-list';
import { Button } from './controls';
import { actions } from '../actions';

const FIELD = 'label-search';

/** Put the cursor into the search. */
export function openSearch(): void {
  const field = document.getElementById(FIELD) as HTMLInputElement | null;
  field?.focus();
  field?.select();
}

export function PaletteSearch() {
  return (
    <>
      <div class="label-search">
        <input
          id={FIELD}
          class="field"
          type="search"
          aria-label="Search labels"
          placeholder={`Search ${listed.value.length} labels`}
          data-tip="Search by name or category"
          data-keys="/"
          spellcheck={false}
          value={search.value}
          onInput={(event) => (search.value = event.currentTarget.value)}
          onKeyDown={onKey}
        />
        {canGroup.value && (
          <Button
            icon="folder"
            tip="Group by category"
            small
            pressed={wantsGroups.value}
            onClick={() => (wantsGroups.value = !wantsGroups.value)}
          />
        )}
      </div>
      <div class="count-head faint" aria-hidden="true">
        Points in this frame
        <br />
        in all frames
      </div>
    </>
  );
}

/** Enter takes the first label that is found; Escape ends the search. */
function onKey(event: KeyboardEvent): void {
  if (event.key !== 'Enter' && event.key !== 'Escape') return;
  event.preventDefault();
  event.stopPropagation();
  const first = shownGroups.peek()[0]?.labels[0];
  if (event.key === 'Enter' && first) actions.selectLabel(first.id);
  search.value = '';
  (event.currentTarget as HTMLElement).blur();
}
