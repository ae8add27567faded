/** Page of the palette for boxes of objects: fitting, copying, and editing by hand. */
import {
  copyToShownFrame,
  copyToFrame,
  fitBoxes,
  interpolate,
  pointsFromBox,
  trackAndFit,
  turnRound,
} from '../../../boxes/changes';
import { metres, percent } from '../../../common/format';
import { actions } from '../../../store/actions';
import { chosenBox, type ObjectBox } from '../../../store/boxes';
import { activeLabel, canEdit, state, trackingJob } from '../../../store/state';
import { INK, type Entry, type Ui } from '../../drawing/ui';
import { VIEWER } from './rows';

/** Signals that the page shows. */
export const BOXES = [chosenBox, state.shown, state.jobs, canEdit] as const;

/** Ems of a tile's height. */
const TILE = 3.2;

export function drawBoxes(ui: Ui, x: number, top: number, inner: number): void {
  const { em } = ui;
  const on = state.tool.peek() === 'boxes';
  ui.check(x, top, inner, em * 2.2, 'Grab boxes', on, (wanted) =>
    actions.tools.setTool(wanted ? 'boxes' : 'paint'),
  );
  const label = activeLabel.peek();
  const box = chosenBox.peek();
  descriptionOf(box, label?.name).forEach((text, i) => {
    ui.text(text, x + em * 0.4, top + em * (3.5 + 1.5 * i), { color: INK.quiet });
  });
  const usable = canEdit.peek() && label !== null;
  const entries = buttons(box).map(([look, run]): Entry => [{ ...look, disabled: look.disabled === true || !usable }, run]); // prettier-ignore
  ui.strip(x, top + em * 7.7, inner, em * TILE, entries, 2);
}

function descriptionOf(box: ObjectBox | null, name: string | undefined): string[] {
  if (!canEdit.peek()) return [VIEWER];
  if (name === undefined) return ['Choose a label first'];
  if (!box) return [`${name} has no box yet`, 'Fit makes it from the points'];
  const size = box.size.map(metres).join(' × ');
  const pose = box.poses[state.shown.peek().frame];
  if (!pose) return [`${name}: not in this frame`, size];
  const how = pose.provenance === 'fitted' ? `fitted, ${percent(pose.confidence)} confidence` : pose.provenance; // prettier-ignore
  return [`${name}: ${how}`, size, ...(box.heading_known ? [] : ['Front unknown'])];
}

function buttons(box: ObjectBox | null): Entry[] {
  const label = state.activeLabel.peek();
  const isInFrame = box !== null && state.shown.peek().frame in box.poses;
  const fit = (): void => void fitBoxes({ labels: [label], category: null, frames: null });
  return [
    [{ icon: 'target', text: 'Fit' }, fit],
    [{ icon: 'track', text: 'Track and fit', disabled: trackingJob.peek() !== null }, trackAndFit],
    [{ icon: 'previous', text: 'Copy backward', disabled: !isInFrame }, () => void copyToFrame(-1)],
    [{ icon: 'next', text: 'Copy forward', disabled: !isInFrame }, () => void copyToFrame(1)],
    [{ icon: 'frames', text: 'Interpolate', disabled: !box }, () => void interpolate()],
    isInFrame || !box
      ? [{ icon: 'points', text: 'Points from box', disabled: !isInFrame }, () => void pointsFromBox(false)]
      : [{ icon: 'pin', text: 'Copy here' }, () => void copyToShownFrame()],
    [{ icon: 'swap', text: 'Turn round', disabled: !box }, () => void turnRound()],
  ]; // prettier-ignore
}
