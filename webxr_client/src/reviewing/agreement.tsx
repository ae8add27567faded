/** Agreement with another annotation of the same points, and the places where they differ. */
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { attempt, sequencePath } from '../engine/recordings';
import { actions } from '../store/actions';
import { api, apiUrl } from '../net/rest';
import { state } from '../store/state';
import { type Agreement, percent, worstFrames } from './model';
import { visit } from './store';

const other = signal('');
const found = signal<Agreement | null>(null);

const LEGEND = [
  ['first', 'only here'],
  ['second', 'only there'],
  ['other', 'other labels'],
  ['same', 'the same'],
] as const;

async function compare(): Promise<void> {
  const id = state.sequence.peek()?.id ?? '';
  const with_ = other.peek();
  found.value = null;
  if (!with_) return;
  await attempt('The recordings were not compared', async () => {
    const query = new URLSearchParams({ with: with_ }).toString();
    const answer = await api<Agreement>('GET', `${sequencePath(id)}/agreement?${query}`);
    if (other.peek() === with_) found.value = answer;
  });
}

export function AgreementTab() {
  const info = state.sequence.value;
  useEffect(() => void actions.refreshSequences(), []);
  const others = (state.sequences.value ?? []).filter(
    ({ id, frames, damaged }) => id !== info?.id && frames === info?.frames && !damaged,
  );
  return (
    <>
      <p class="soft">
        Compare with another import of the same points, labelled by another person:
      </p>
      <select
        aria-label="The other recording"
        value={other.value}
        onChange={(event) => {
          other.value = event.currentTarget.value;
          void compare();
        }}
      >
        <option value="">{others.length > 0 ? 'Choose a recording' : 'No other recording'}</option>
        {others.map(({ id, name }) => (
          <option key={id} value={id}>
            {name === info?.name ? id : name}
          </option>
        ))}
      </select>
      {found.value && <Result agreement={found.value} />}
    </>
  );
}

function Result({ agreement }: { agreement: Agreement }) {
  return (
    <>
      <Figures agreement={agreement} />
      <Picture />
      <Worst agreement={agreement} />
    </>
  );
}

/** Agreement of two people by points, in all and by label. */
export function Figures({ agreement: { same, miou, labels } }: { agreement: Agreement }) {
  return (
    <>
      <p class="agreement-head">
        <strong>{percent(same)}</strong> <span class="soft">of labelled points agree</span>
        <br />
        <strong>{percent(miou)}</strong> <span class="soft">mean IoU</span>
      </p>
      <table>
        <thead>
          <tr>
            <th>Label</th>
            <th>IoU</th>
          </tr>
        </thead>
        <tbody>
          {labels.map(({ name, iou }) => (
            <tr key={name}>
              <td>{name}</td>
              <td>
                <meter min={0} max={1} low={0.5} high={0.8} optimum={1} value={iou} />
                {percent(iou)}
              </td>
            </tr>
          ))}
        </tbody>
      </table>
    </>
  );
}

/** Colours of a difference in words: first, second, other, same. */
export function Legend({ words }: { words: readonly (readonly [string, string])[] }) {
  return (
    <>
      {words.map(([kind, told]) => (
        <span key={kind} data-difference={kind}>
          {told}
        </span>
      ))}
    </>
  );
}

function Picture() {
  const { id = '' } = state.sequence.value ?? {};
  const frame = state.frame.value;
  const query = new URLSearchParams({ with: other.value }).toString();
  return (
    <figure>
      <img
        src={apiUrl(`${sequencePath(id)}/frames/${frame}/agreement?${query}`)}
        alt={`Frame ${frame} from above: where the labels differ`}
      />
      <figcaption>
        <Legend words={LEGEND} />
      </figcaption>
    </figure>
  );
}

function Worst({ agreement }: { agreement: Agreement }) {
  const worst = worstFrames(agreement);
  if (worst.length === 0) return null;
  return (
    <div class="worst" role="group" aria-label="Frames with the largest differences">
      <span class="soft">Largest differences:</span>
      {worst.map(({ frame, differ, labelled }) => (
        <button
          key={frame}
          type="button"
          class="button small outlined"
          data-tip={`${percent(differ / labelled)} of the labelled points`}
          onClick={() => visit(frame, null)}
        >
          {frame}
        </button>
      ))}
    </div>
  );
}
