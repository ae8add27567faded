/** Summary of the changes that applying the prediction would make, by the frame on screen. */
import { useMemo } from 'preact/hooks';
import { count, percent, plural } from '../common/format';
import { Swatch } from '../panels/parts/controls';
import { state } from '../store/state';
import { coloursOf, type Prediction, talliesOf } from './model';
import { classifier, looking, predicted } from './store';

/** `least` confidence, 0..1; `whole`: the frame on screen is all that changes. */
export function Summary({ least, whole }: { least: number; whole: boolean }) {
  const prediction = predicted.value;
  const { classes } = classifier.value!;
  const counts = state.counts.value;
  const open = useMemo(() => prediction && looking.open?.(prediction), [prediction, counts]);
  if (!prediction || !open) return <p class="soft">There is no prediction of this frame yet.</p>;
  const tallies = talliesOf(
    prediction,
    classes.length,
    Math.round(least * 255),
    (point) => open[point] === 1,
  );
  const [all, ...each] = tallies as [(typeof tallies)[number], ...typeof tallies];
  const colours = coloursOf(classes, state.palette.value);
  return (
    <div class="stack" role="group" aria-label="Changes">
      <p>
        <b>{plural(all.points, 'point')}</b> {whole ? 'get' : 'of the frame on screen get'} a label,{' '}
        with a mean confidence of {percent(all.sure / Math.max(1, all.points))}:
      </p>
      <ul class="stack">
        {each.map(({ points }, k) => points > 0 && (
          <li key={k} class="line">
            <Swatch color={colours[k]!} /> <span class="grow">{classes[k]}</span>
            <span class="number">{count(points)}</span>
          </li>
        ))}
      </ul>
      <p class="soft">{stays(prediction, open, all.points)} One undo reverts everything.</p>
    </div>
  ); // prettier-ignore
}

function stays({ kind }: Prediction, open: Uint8Array, changed: number): string {
  const labelled = open.reduce((sum, free) => sum + (1 - free), 0);
  const unsure = kind.length - labelled - changed;
  return `${plural(labelled, 'labelled point')} keep their label; ${count(unsure)} stay without one.`;
}
