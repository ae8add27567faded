/** A questionnaire: a form with a scale of radio buttons for each item. */
import { Button } from '../panels/parts/controls';
import type { QuestionItem, Questionnaire } from '../protocol/values';
import { finish } from './session';
import { finishing } from './step';

export function Questions({ of: { name, title, items } }: { of: Questionnaire }) {
  const submit = (event: SubmitEvent): void => {
    event.preventDefault();
    const answers = new FormData(event.currentTarget as HTMLFormElement);
    void finish(items.map((_, i) => Number(answers.get(String(i)))));
  };
  return (
    <form class="stack" onSubmit={submit}>
      <h2>{title || name}</h2>
      {items.map((item, i) => (
        <Scale key={i} name={String(i)} of={item} />
      ))}
      <footer class="form-end">
        <Button submit label="Continue" kind="primary" disabled={finishing.value} />
      </footer>
    </form>
  );
}

/** The browser does not submit the form before each item is answered. */
function Scale({ name, of: { text, low, high, steps } }: { name: string; of: QuestionItem }) {
  return (
    <div class="card stack" role="radiogroup" aria-label={`${text} 1: ${low}, ${steps}: ${high}`}>
      <strong>{text}</strong>
      <div class="group spread">
        {Array.from({ length: steps }, (_, i) => i + 1).map((value) => (
          <input key={value} type="radio" name={name} value={value} required aria-label={String(value)} />
        ))}
      </div>
      <div class="line spread soft">
        <span>{low}</span>
        <span>{high}</span>
      </div>
    </div>
  ); // prettier-ignore
}
