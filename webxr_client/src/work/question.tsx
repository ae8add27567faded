/** The question before a task without a change is handed in. */
import { useModal } from '../panels/parts/modal';
import { state } from '../store/state';
import { question, taskWords } from './queue';

const YES = 'yes';

export function HandInQuestion() {
  const shown = state.xr.value.session === 'running' ? null : question.value;
  const dialog = useModal(shown !== null);
  if (!shown) return null;
  return (
    <dialog
      ref={dialog}
      class="card question"
      aria-labelledby="hand-in-question"
      onClose={() => shown.answer(dialog.current?.returnValue === YES)}
      onKeyDown={(event) => event.stopPropagation()}
    >
      <form class="stack" method="dialog">
        <h2 class="title" id="hand-in-question">
          Hand in without changes?
        </h2>
        <p>You have not changed anything in {taskWords(shown.task)} since you got this task.</p>
        <div class="line">
          <button class="button primary">Keep working</button>
          <button class="button outlined" value={YES}>
            Hand in anyway
          </button>
        </div>
      </form>
    </dialog>
  );
}
