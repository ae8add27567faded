/** The desk's panels, around the canvas of `index.html`. */
import { render, type ComponentChild } from 'preact';
import { state } from '../state';
import { CommandPalette } from './command-palette';
import { Help } from './help';
import { ImportDialog } from './import-dialog';
import { acceptDrops } from './import-files';
import { InsecureHeadset } from './insecure';
import { Palette } from './palette';
import { Stage } from './stage';
import { Timeline } from './timeline';
import { Toolbar } from './toolbar';
import { Tooltip } from './tooltip';
import { Tour } from './tour';
import { follow } from '../watch';

/** Nobody looks at these from inside a headset, and they would be drawn anew for every frame. */
function AtTheDesk({ panel: Panel }: { panel: () => ComponentChild }) {
  return state.xr.value.session === 'running' ? null : <Panel />;
}

/** Fill the places of the page; the result empties them again. */
export function mountPanels(): () => void {
  const page = document;
  const places: [string, ComponentChild][] = [
    ['toolbar', <Toolbar />],
    ['palette', <AtTheDesk panel={Palette} />],
    ['overlay', <Stage />],
    ['timeline', <AtTheDesk panel={Timeline} />],
    ['panels', [<Tooltip />, <Help />, <CommandPalette />, <ImportDialog />, <InsecureHeadset />, <AtTheDesk panel={Tour} />]], // prettier-ignore
  ];
  for (const [id, panel] of places) render(panel, page.getElementById(id)!);
  const layout = follow(() => {
    page.getElementById('app')!.classList.toggle('welcome', state.sequence.value === null);
    page.title = state.sequence.value ? `${state.sequence.value.name} · pointbrush` : 'pointbrush';
  });
  const drops = acceptDrops();
  return () => {
    drops();
    layout();
    for (const [id] of places) render(null, page.getElementById(id)!);
  };
}
