/** A questionnaire: each item is a scale, of radio buttons or, if it is long, a slider. */
import { useState } from 'preact/hooks';
import { Button } from '../panels/parts/controls';
import { RadioGroup } from '../panels/parts/radio-group';
import type { QuestionItem, Questionnaire } from '../protocol/values';
import { finish, finishing } from './step';

/** Longest scale of radio buttons. */
const MOST_RADIOS = 11;

type Answer = number | null;

export function Questions({ of: { name, title, items } }: { of: Questionnaire }) {
  const [answers, setAnswers] = useState<readonly Answer[]>(() => items.map(() => null));
  const given = answers.filter((answer) => answer !== null);
  const choose = (i: number, answer: number): void =>
    setAnswers(answers.map((old, k) => (k === i ? answer : old)));
  return (
    <>
      <h2>{title || name}</h2>
      {items.map((item, i) => (
        <div key={i} class="card stack">
          <strong>{item.text}</strong>
          <div class="line spread soft">
            {item.low}
            <Scale of={item} value={answers[i]!} onChoose={(answer) => choose(i, answer)} />
            {item.high}
          </div>
        </div>
      ))}
      <footer class="line spread">
        <span class="soft" role="status">
          {given.length} of {items.length} answered
        </span>
        <Button label="Continue" kind="primary" disabled={given.length < items.length || finishing.value}
          onClick={() => void finish(given)} />
      </footer>
    </>
  ); // prettier-ignore
}

interface ScaleProps {
  of: QuestionItem;
  value: Answer;
  onChoose: (answer: number) => void;
}

function Scale({ of: { text, low, high, steps }, value, onChoose }: ScaleProps) {
  const label = `${text} 1: ${low}, ${steps}: ${high}`;
  const shown = value ?? Math.ceil(steps / 2);
  if (steps <= MOST_RADIOS) {
    const options = Array.from({ length: steps }, (_, i) => String(i + 1));
    return (
      <RadioGroup label={label} options={options.map((each) => ({ value: each, label: each }))}
        value={value === null ? null : String(value)} onChoose={(each) => onChoose(Number(each))} />
    ); // prettier-ignore
  }
  // A slider counts once it was used; a click in its middle is an answer as well.
  const take = (event: { currentTarget: HTMLInputElement }): void =>
    onChoose(event.currentTarget.valueAsNumber);
  return (
    <span class="slider grow">
      <input type="range" class="grow" aria-label={label} aria-valuetext={value === null ? 'not answered' : String(value)}
        min={1} max={steps} value={shown} style={{ '--fill': String((shown - 1) / (steps - 1)) }} onInput={take} onClick={take} />
      <output>{value ?? '–'}</output>
    </span>
  ); // prettier-ignore
}
