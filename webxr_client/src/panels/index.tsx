/** The desk's panels, around the canvas of `index.html`. */
import { render, type ComponentChild } from 'preact';
import { newLabel } from '../engine/labels/labels';
import { listOpen, renaming } from '../store/palette-list';
import { state } from '../store/state';
import { ImportDialog } from './importing/dialog';
import { acceptDrops } from './importing/files';
import { InsecureHeadset } from './insecure';
import { Palette } from './labels/palette';
import { Stage } from './stage/stage';
import { Timeline } from './timeline/timeline';
import { Toolbar } from './toolbar';
import { Tooltip } from './parts/tooltip';
import { Tour } from './tour';
import { follow } from '../store/watch';

/** Hides a panel during a headset session, where it is invisible but would render each frame. */
function AtTheDesk({ panel: Panel }: { panel: () => ComponentChild }) {
  return state.xr.value.session === 'running' ? null : <Panel />;
}

type Panel = () => ComponentChild;

/** Additions to the panels by the layers above. */
export interface MorePanels {
  readonly buttons: readonly Panel[];
  /** Over the canvas, at the bottom. */
  readonly bars: readonly Panel[];
  readonly dialogs: readonly Panel[];
}

/** Fill the places of the page; the result empties them again. */
export function mountPanels({ buttons, bars, dialogs }: MorePanels): () => void {
  const page = document;
  const places: [string, ComponentChild][] = [
    ['toolbar', <Toolbar buttons={buttons} />],
    ['palette', <AtTheDesk panel={Palette} />],
    ['overlay', <Stage bars={bars} />],
    ['timeline', <AtTheDesk panel={Timeline} />],
    ['panels', [<Tooltip />, dialogs.map((Dialog) => <Dialog />), <ImportDialog />, <InsecureHeadset />, <AtTheDesk panel={Tour} />]], // prettier-ignore
  ];
  for (const [id, panel] of places) render(panel, page.getElementById(id)!);
  const layout = follow(() => {
    const app = page.getElementById('app')!.classList;
    app.toggle('welcome', state.sequence.value === null);
    app.toggle('listing', listOpen.value || newLabel.value !== null || renaming.value !== null);
    page.title = state.sequence.value ? `${state.sequence.value.name} · pointbrush` : 'pointbrush';
  });
  const drops = acceptDrops();
  return () => {
    drops();
    layout();
    for (const [id] of places) render(null, page.getElementById(id)!);
  };
}
