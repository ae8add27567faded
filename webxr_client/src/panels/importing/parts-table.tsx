/** Recordings before their import, one a row: format and size, and whether to import it. */
import { changePart } from '../../engine/recordings/importing';
import { bytes, count, plural } from '../../common/format';
import type { ImportPart } from '../../store/state';
import { inSight, listStyle, useSight } from '../parts/scrolled';
import { onPage } from './found';

export function PartsTable({ parts, busy }: { parts: readonly ImportPart[]; busy: boolean }) {
  const [box, sight] = useSight();
  const [from, until] = inSight(sight, 1, parts.length);
  const chosen = parts.filter(({ included }) => included).length;
  return (
    <div
      ref={box}
      class="import-files parts small"
      role="region"
      aria-label="Recordings to import"
      tabIndex={0}
    >
      <table aria-rowcount={parts.length + 1}>
        <thead>
          <tr>
            <th>
              <input
                type="checkbox"
                aria-label="Import all"
                checked={chosen === parts.length}
                onChange={(event) => changePart({ included: event.currentTarget.checked })}
              />
            </th>
            <th scope="col">{`${count(chosen)} of ${plural(parts.length, 'recording')}`}</th>
            <th scope="col">Format</th>
            <th scope="col">Frames</th>
            <th scope="col">Size</th>
            <th scope="col">Problems</th>
          </tr>
        </thead>
        <tbody>
          <tr aria-hidden="true" style={listStyle(from, 0)} />
          {parts.slice(from, until).map((part, k) => (
            <PartRow key={from + k} part={part} number={from + k} busy={busy} />
          ))}
          <tr aria-hidden="true" style={listStyle(parts.length - until, 0)} />
        </tbody>
      </table>
    </div>
  );
}

function PartRow({ part, number, busy }: { part: ImportPart; number: number; busy: boolean }) {
  const { found, error, included } = part;
  const name = found?.name ?? part.name;
  const format = busy && !found && !error ? 'reading…' : found?.title;
  return (
    <tr aria-rowindex={number + 2}>
      <td>
        <input
          type="checkbox"
          aria-label={`Import ${name}`}
          checked={included}
          onChange={(event) => changePart({ included: event.currentTarget.checked }, number)}
        />
      </td>
      <th scope="row" title={name}>
        {name}
      </th>
      <td title={format}>{format}</td>
      <td class="number">{found && (found.frames === null ? 'several' : count(found.frames))}</td>
      <td class="number">{bytes(part.bytes)}</td>
      <Problems lines={error ? [error] : (found?.warnings ?? [])} bad={error !== ''} />
    </tr>
  );
}

function Problems({ lines, bad }: { lines: readonly string[]; bad: boolean }) {
  const [first = '', ...others] = lines.map(onPage);
  return (
    <td class={bad ? 'bad' : 'warn'} title={[first, ...others].join('\n')}>
      {others.length > 0 && `${lines.length}: `}
      {first}
    </td>
  );
}
