/** Cards that point at the controls of the first steps; they leave the page to be used. */
import { computed } from '@preact/signals';
import { createPortal } from 'preact/compat';
import { useEffect, useLayoutEffect, useRef, useState } from 'preact/hooks';
import { actions } from '../store/actions';
import { choosesRecording } from '../common/checking';
import { canEdit, state } from '../store/state';
import { follow, watch } from '../store/watch';
import { Button } from './parts/controls';
import {
  beginTour,
  leaveTour,
  placeCard,
  stepsFor,
  stepTour,
  tourIsNew,
  tourStep,
  type TourStep,
} from './tour-steps';

const hasPicture = computed(() => state.sequence.value !== null && state.shown.value.total > 0);

export function Tour() {
  useEffect(
    () =>
      follow(() => {
        const begins = hasPicture.value && tourStep.peek() === null && !choosesRecording();
        if (begins && tourIsNew()) beginTour();
      }),
    [],
  );
  const number = tourStep.value;
  if (number === null || !hasPicture.value) return null;
  const steps = stepsFor(canEdit.value);
  // The user's role may change during the tour.
  const shown = Math.min(number, steps.length - 1);
  return createPortal(
    <Card step={steps[shown]!} number={shown} count={steps.length} />,
    document.getElementById('dialogs')!,
  );
}

interface CardProps {
  step: TourStep;
  number: number;
  count: number;
}

function Card({ step, number, count }: CardProps) {
  const box = useRef<HTMLDivElement>(null);
  const next = useRef<HTMLButtonElement>(null);
  useReturnOfFocus(box);
  useEffect(() => {
    if (step.objects) takeObjects();
    next.current?.focus({ preventScroll: true });
  }, [step]);
  usePlace(box, step.at);
  // Before the card is seen: a key may follow it at once.
  useLayoutEffect(() => {
    document.addEventListener('keydown', leaveByEscape);
    return () => document.removeEventListener('keydown', leaveByEscape);
  }, []);
  const last = number === count - 1;
  return (
    <div
      ref={box}
      class="popover form tour"
      role="dialog"
      aria-labelledby="tour-title"
      aria-describedby="tour-text"
      onKeyDown={keepForButtons}
    >
      <div aria-live="polite">
        <div class="line baseline spread">
          <h2 id="tour-title">{step.title}</h2>
          <span class="faint number">
            {number + 1} of {count}
          </span>
        </div>
        <p id="tour-text" class="soft">
          {step.text}
        </p>
      </div>
      <div class="line">
        {!last && <Button label="Leave" keys="Esc" tip="Leave the tour" onClick={leaveTour} />}
        <span class="spacer" />
        {number > 0 && <Button label="Back" kind="outlined" onClick={() => stepTour(-1, count)} />}
        <Button
          buttonRef={next}
          label={last ? 'Done' : 'Next'}
          kind="primary"
          onClick={() => stepTour(1, count)}
        />
      </div>
    </div>
  );
}

function takeObjects(): void {
  actions.tools.setTool('paint');
  actions.tools.setShape('object');
}

/** Return the focus to the element that had it before the tour, or else to the picture. */
function useReturnOfFocus(box: { current: HTMLElement | null }): void {
  useLayoutEffect(() => {
    const before = document.activeElement;
    const card = box.current!;
    return () => {
      const { activeElement } = document;
      if (activeElement !== document.body && !card.contains(activeElement)) return;
      const back = before !== document.body && before?.isConnected ? before : null;
      ((back ?? document.getElementById('view')) as HTMLElement).focus({ preventScroll: true });
    };
  }, [box]);
}

/** Put the card at its control, and mark the control, for as long as the step lasts. */
function usePlace(box: { current: HTMLElement | null }, at: string): void {
  const [, placeAnew] = useState({});
  useEffect(() => {
    const resized = new ResizeObserver(() => placeAnew({}));
    resized.observe(document.getElementById('stage')!);
    // The toolbar's second row changes with the tool, and with the width of its texts.
    const { tool, brush, activeLabel, palette } = state;
    const stop = watch([tool, brush, activeLabel, palette], () => placeAnew({}));
    return () => {
      resized.disconnect();
      stop();
    };
  }, []);
  useEffect(() => {
    const control = document.querySelector(at);
    const card = box.current;
    if (!control || !card) return undefined;
    const size = { width: card.offsetWidth, height: card.offsetHeight };
    const { left, top, side, tip } = placeCard(control.getBoundingClientRect(), size, { width: innerWidth, height: innerHeight }); // prettier-ignore
    Object.assign(card.style, { left: `${left}px`, top: `${top}px` });
    card.style.setProperty('--tip-at', `${tip}px`);
    card.dataset['side'] = side;
    control.setAttribute('data-tour', '');
    return () => control.removeAttribute('data-tour');
  });
}

/** Keys that press buttons and go from one to the next are no shortcuts here. */
function keepForButtons(event: KeyboardEvent): void {
  if (event.key === 'Tab' || event.key === ' ' || event.key === 'Enter') event.stopPropagation();
}

/** Escape leaves the tour, unless it closes or cancels something else. */
function leaveByEscape(event: KeyboardEvent): void {
  if (event.key !== 'Escape' || event.defaultPrevented) return;
  const typing = event.target instanceof HTMLInputElement && event.target.type !== 'range';
  if (typing || document.querySelector('dialog[open]') || state.object.peek()?.taken) return;
  event.preventDefault();
  leaveTour();
}
