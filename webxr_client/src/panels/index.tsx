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
  /** Beside the stage, from left to right: identifier, accessible name and panel. */
  readonly asides: readonly (readonly [id: string, label: string, panel: Panel])[];
}

/** Fill the places of the page. */
export function mountPanels({ buttons, bars, dialogs, asides }: MorePanels): void {
  const page = document;
  const places: [string, ComponentChild][] = [
    ['toolbar', <Toolbar buttons={buttons} />],
    ['palette', <AtTheDesk panel={Palette} />],
    ['overlay', <Stage bars={bars} />],
    ['timeline', <AtTheDesk panel={Timeline} />],
    ['panels', [<Tooltip />, dialogs.map((Dialog) => <Dialog />), <ImportDialog />, <InsecureHeadset />, <AtTheDesk panel={Tour} />]], // prettier-ignore
  ];
  for (const [id, panel] of places) render(panel, page.getElementById(id)!);
  let before = page.getElementById('stage')!;
  for (const [id, label, Panel] of asides) {
    const aside = page.createElement('aside');
    aside.id = id;
    aside.setAttribute('aria-label', label);
    before.after(aside);
    before = aside;
    render(<Panel />, aside);
  }
  follow(() => {
    const app = page.getElementById('app')!.classList;
    app.toggle('welcome', state.sequence.value === null);
    app.toggle('listing', listOpen.value || newLabel.value !== null || renaming.value !== null);
    page.title = state.sequence.value ? `${state.sequence.value.name} · pointbrush` : 'pointbrush';
  });
  acceptDrops();
}
