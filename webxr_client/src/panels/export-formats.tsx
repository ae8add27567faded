/** Formats of the export menu by purpose, and the losses of the format under the pointer or focus. */
import type { ExportFormat } from '../protocol/values';
import { useState } from 'preact/hooks';
import {
  exportFormats,
  groupFormats,
  lastExport,
  type FormatGroup,
} from '../engine/recordings/export-formats';
import { boxes } from '../store/boxes';
import type { ComponentChildren } from 'preact';

interface ExportFormatsProps {
  /** Options of formats that split their frames. */
  split: ComponentChildren;
  start: (format: ExportFormat) => void;
}

export function ExportFormats({ split, start }: ExportFormatsProps) {
  const [chosen, choose] = useState(lastExport.value);
  const groups = groupFormats(exportFormats.value, boxes.value.size > 0);
  const offered = groups.flatMap(({ formats }) => formats);
  const shown = offered.find(({ format }) => format === chosen) ?? offered[0];
  return (
    <div class="export-formats stack">
      <div>
        {groups.map((group) => (
          <Group key={group.purpose} group={group} shown={shown} choose={choose} start={start}>
            {group.formats.some(({ splits }) => splits) && split}
          </Group>
        ))}
      </div>
      {shown && <Details format={shown} />}
    </div>
  );
}

interface GroupProps {
  group: FormatGroup;
  shown: ExportFormat | undefined;
  choose: (format: string) => void;
  start: (format: ExportFormat) => void;
  children: ComponentChildren;
}

function Group({ group: { purpose, formats }, shown, choose, start, children }: GroupProps) {
  return (
    <section aria-label={purpose}>
      <h3>{purpose}</h3>
      {children}
      <div class="export-list">
        {formats.map((each) => (
          <button
            key={each.format}
            type="button"
            class="menu-item export-format"
            aria-description={[each.content, ...losses(each)].join('. ')}
            data-shown={each === shown || undefined}
            onPointerEnter={() => choose(each.format)}
            onFocus={() => choose(each.format)}
            onClick={() => start(each)}
          >
            {each.title}
            {each.format === lastExport.value && <span class="end">last used</span>}
          </button>
        ))}
      </div>
    </section>
  );
}

function losses({ cannot_hold }: ExportFormat): readonly string[] {
  return cannot_hold.length > 0 ? [`Not stored: ${cannot_hold.join(', ')}`] : [];
}

function Details({ format: { title, content, cannot_hold } }: { format: ExportFormat }) {
  return (
    <div class="export-details stack">
      <strong>{title}</strong>
      <p class="soft">{content}</p>
      {cannot_hold.length > 0 && (
        <>
          <h3>Not stored</h3>
          <ul>
            {cannot_hold.map((each) => (
              <li key={each}>{each}</li>
            ))}
          </ul>
        </>
      )}
    </div>
  );
}
