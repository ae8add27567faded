/** Steps of a participant at the desk: cards to read and to answer, and a task in the tool bar. */
import { apiUrl } from '../net/rest';
import { Button } from '../panels/parts/controls';
import { useModal } from '../panels/parts/modal';
import type { QuestionItem, Questionnaire, StudyStep } from '../protocol/values';
import { actions } from '../store/actions';
import { state } from '../store/state';
import { finish } from './session';
import { activeStep, finishing, isTask, isWorn, timeLeft, wordsOf } from './step';

/** The task in the tool bar: its name, the time left, and the button that ends it. */
export function StudyBar() {
  const step = activeStep.value;
  if (!step?.task) return null;
  const [title, text, button] = wordsOf(step);
  return (
    <div class="line" role="group" aria-label="Task">
      <strong class="title" data-tip={text}>
        {title}
      </strong>
      <span class="soft small number">
        Step {step.number + 1} of {step.count}
      </span>
      <span class="number" role="timer">
        {timeLeft()}
      </span>
      {isTask(step) && <NextButton label={button} />}
    </div>
  );
}

/** The button that finishes the step; none without words. */
function NextButton({ label }: { label: string }) {
  const next = (): void => void finish([]);
  return label ? (
    <Button label={label} kind="primary" disabled={finishing.value} onClick={next} />
  ) : null;
}

export function StudyCards() {
  const step = activeStep.value;
  const worn = state.xr.value.session === 'running';
  if (!step || worn || (isTask(step) && !isWorn(step))) return null;
  return <Card key={`${step.number} ${step.kind}`} step={step} />;
}

/** A step is left by its own button only. */
function stay(event: Event): void {
  if (!(event instanceof KeyboardEvent) || event.key === 'Escape') event.preventDefault();
}

function Card({ step }: { step: StudyStep }) {
  const dialog = useModal();
  const questionnaire = step.kind === 'questionnaire' && step.questionnaire;
  return (
    <dialog ref={dialog} class="settings" aria-label={step.title} onCancel={stay} onKeyDown={stay}>
      <header class="line spread soft">
        <span>{step.title}</span>
        <span>
          Step {step.number + 1} of {step.count}
        </span>
      </header>
      <div class="settings-body stack">
        {questionnaire ? <Questions of={questionnaire} /> : <Reading step={step} />}
      </div>
    </dialog>
  );
}

function Reading({ step }: { step: StudyStep }) {
  const { task, sequence, start } = step;
  const [title, text, button] = wordsOf(step);
  const worn = isWorn(step);
  const thumbnail = sequence && apiUrl(`sequences/${sequence}/frames/${start}/thumbnail`);
  const picture = task?.picture || thumbnail;
  return (
    <>
      <h2>{worn ? `${title}: put on the headset` : title}</h2>
      {text.split(/\n\s*\n/).map((each) => (
        <p key={each}>{each}</p>
      ))}
      {button && picture && <img src={picture} alt="" style={{ maxWidth: '100%' }} />}
      <footer class="form-end">{worn ? <EnterButton /> : <NextButton label={button} />}</footer>
    </>
  );
}

function EnterButton() {
  const { supported, session, detail } = state.xr.value;
  return (
    <>
      {supported === false && <p class="note grow">{detail}</p>}
      <Button icon="headset" label="Enter VR" kind="primary" disabled={!supported || session === 'starting'}
        onClick={() => void actions.page.enterVR()} />
    </>
  ); // prettier-ignore
}

/** A form with a scale of radio buttons for each item. */
function Questions({ of: { name, title, items } }: { of: Questionnaire }) {
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
