/** Legend of the strips' colours. */
import { signal } from '@preact/signals';
import { useRef } from 'preact/hooks';
import { activeLabel } from '../state';
import { Button } from './controls';
import { Popover } from './popover';
import { drawSample } from './timeline-draw';
import { inkNow } from './timeline-strips';
import type { Run } from './timeline-layout';

const open = signal(false);
const close = (): void => {
  open.value = false;
};

type Sample = Pick<Run, 'kind' | 'sure'>;

const LINES: readonly (readonly [Sample, string])[] = [
  [{ kind: 'painted' }, 'Painted or accepted by a person'],
  [{ kind: 'tracked', sure: 1 }, 'Tracked, sure'],
  [{ kind: 'tracked', sure: 0.6 }, 'Tracked, less sure: paler'],
  [{ kind: 'doubtful' }, 'Tracked, doubtful: have a look'],
  [{ kind: 'occluded' }, 'Hidden behind something'],
  [{ kind: 'lost' }, 'Lost: have a look'],
];

export function StripLegend() {
  const anchor = useRef<HTMLButtonElement>(null);
  return (
    <>
      <Button
        buttonRef={anchor}
        icon="help"
        tip="What the strips mean"
        expanded={open.value}
        onClick={() => (open.value = !open.value)}
      />
      {open.value && (
        <Popover anchor={anchor} label="What the strips mean" onClose={close}>
          <ul class="strip-legend">
            {LINES.map(([sample, words]) => (
              <li key={words}>
                <canvas width={44} height={14} ref={(canvas) => draw(canvas, sample)} />
                {words}
              </li>
            ))}
          </ul>
        </Popover>
      )}
    </>
  );
}

function draw(canvas: HTMLCanvasElement | null, sample: Sample): void {
  const pen = canvas?.getContext('2d');
  if (pen) drawSample(pen, sample, activeLabel.peek()?.color ?? '#5ea2ff', 44, 14, inkNow());
}
