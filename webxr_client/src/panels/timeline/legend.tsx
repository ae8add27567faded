/** Legend of the strips' colours. */
import { signal } from '@preact/signals';
import { activeLabel } from '../../store/state';
import { PopoverButton } from '../parts/popover';
import { drawSample } from './draw';
import { inkNow } from './strips';
import type { Run } from './layout';

const open = signal(false);

type Sample = Pick<Run, 'kind' | 'sure'>;

const LINES: readonly (readonly [Sample, string])[] = [
  [{ kind: 'painted' }, 'Painted or confirmed by a person'],
  [{ kind: 'tracked', sure: 1 }, 'Tracked, certain'],
  [{ kind: 'tracked', sure: 0.6 }, 'Tracked, less certain (paler)'],
  [{ kind: 'doubtful' }, 'Tracked, doubtful: check these frames'],
  [{ kind: 'occluded' }, 'Occluded'],
  [{ kind: 'lost' }, 'Lost: check these frames'],
];

export function StripLegend() {
  return (
    <PopoverButton open={open} icon="help" tip="Legend of the strips" label="Legend of the strips">
      <ul class="stack">
        {LINES.map(([sample, words]) => (
          <li key={words} class="line">
            <canvas width={44} height={14} ref={(canvas) => draw(canvas, sample)} />
            {words}
          </li>
        ))}
      </ul>
    </PopoverButton>
  );
}

function draw(canvas: HTMLCanvasElement | null, sample: Sample): void {
  const pen = canvas?.getContext('2d');
  if (pen) drawSample(pen, sample, activeLabel.peek()?.color ?? '#5ea2ff', 44, 14, inkNow());
}
