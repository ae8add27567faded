/** The review at the side: suspicious things, states and notes, people, agreement, report. */
import { render } from 'preact';
import { sequencePath } from '../engine/recordings';
import { apiUrl } from '../net/rest';
import { Button } from '../panels/parts/controls';
import { state } from '../store/state';
import { follow } from '../store/watch';
import { AgreementTab } from './agreement';
import { Findings } from './findings';
import { FrameStates } from './frame-states';
import { People } from './people';
import { closeReview, followEdits, reviewOpen, reviewTab, type ReviewTab, waiting } from './store';

const TABS: readonly (readonly [ReviewTab, string])[] = [
  ['findings', 'Suspicious'],
  ['frames', 'States'],
  ['people', 'People'],
  ['agreement', 'Agreement'],
];
const PANELS = {
  findings: Findings,
  frames: FrameStates,
  people: People,
  agreement: AgreementTab,
} as const;

function ReviewPanel() {
  if (!reviewOpen.value || !state.sequence.value) return null;
  if (state.xr.value.session === 'running') return null;
  const Panel = PANELS[reviewTab.value];
  return (
    <>
      <header>
        <h2>Review</h2>
        <Button icon="close" tip="Close the review" small onClick={closeReview} />
      </header>
      <Tabs />
      <div class="review-body" role="tabpanel" aria-labelledby={`review-${reviewTab.value}`}>
        <Panel />
      </div>
      <Report />
    </>
  );
}

function Tabs() {
  const move = (event: KeyboardEvent): void => {
    const way = event.key === 'ArrowRight' ? 1 : event.key === 'ArrowLeft' ? -1 : 0;
    if (way === 0) return;
    event.preventDefault();
    event.stopPropagation();
    const at = TABS.findIndex(([tab]) => tab === reviewTab.value);
    const [next] = TABS[(at + way + TABS.length) % TABS.length]!;
    reviewTab.value = next;
    document.getElementById(`review-${next}`)?.focus();
  };
  return (
    <div class="review-tabs" role="tablist" aria-label="Review" onKeyDown={move}>
      {TABS.map(([tab, name]) => (
        <button
          key={tab}
          id={`review-${tab}`}
          type="button"
          role="tab"
          class="button"
          aria-selected={reviewTab.value === tab}
          tabIndex={reviewTab.value === tab ? 0 : -1}
          onClick={() => (reviewTab.value = tab)}
        >
          {name}
          {tab === 'findings' && waiting.value.length > 0 && (
            <span class="badge">{waiting.value.length}</span>
          )}
        </button>
      ))}
    </div>
  );
}

function Report() {
  const base = apiUrl(`${sequencePath(state.sequence.value?.id ?? '')}/report`);
  const csv = (table: string): string => `${base}?format=csv&table=${table}`;
  return (
    <footer>
      <a class="button outlined" href={base} target="_blank" rel="noreferrer">
        Report
      </a>
      <span class="soft">as tables:</span>
      {['frames', 'labels', 'people'].map((table) => (
        <a key={table} href={csv(table)} download>
          {table}
        </a>
      ))}
    </footer>
  );
}

/** Put the panel beside the stage; the result takes it away again. */
export function mountReview(): () => void {
  const app = document.getElementById('app')!;
  const place = document.createElement('aside');
  place.id = 'review';
  place.setAttribute('aria-label', 'Review');
  document.getElementById('stage')!.after(place);
  render(<ReviewPanel />, place);
  const edits = followEdits();
  const layout = follow(() => {
    const open = reviewOpen.value && state.sequence.value !== null;
    app.classList.toggle('reviewing', open && state.xr.value.session !== 'running');
  });
  return () => {
    layout();
    edits();
    render(null, place);
    place.remove();
  };
}

/** Opens the review. */
export function ReviewButton() {
  const open = reviewOpen.value;
  return (
    <Button
      icon="check"
      label="Review"
      tip="Suspicious labels, states and notes, people, agreement, report"
      pressed={open}
      onClick={() => (open ? closeReview() : (reviewOpen.value = true))}
    />
  );
}
