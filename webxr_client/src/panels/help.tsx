/** The keyboard and the mouse, on one page. */
import { signal } from '@preact/signals';
import { useEffect, useRef } from 'preact/hooks';
import { KEYS, WALK_KEYS } from '../desktop/keys';
import { Button } from './controls';

export const helpOpen = signal(false);

const MOUSE = [
  ['Left drag', 'Use the tool'],
  ['Alt + left drag, middle drag', 'Turn the view'],
  ['Right drag', 'Move the view'],
  ['Wheel', 'Come closer, go away'],
  ['Drag on the ruler', 'Scrub through time'],
  ['Drag on the strips', 'Choose a range of frames'],
] as const;

const GROUPS = ['Time', 'Tools', 'Labels', 'Edit', 'View'] as const;

export function Help() {
  const dialog = useRef<HTMLDialogElement>(null);
  const open = helpOpen.value;
  useEffect(() => {
    if (open) dialog.current?.showModal();
  }, [open]);
  if (!open) return null;
  const close = (): void => {
    helpOpen.value = false;
  };
  return (
    <dialog
      ref={dialog}
      class="help"
      aria-label="Keyboard and mouse"
      onClose={close}
      onClick={(event) => event.target === dialog.current && dialog.current?.close()}
    >
      <div class="help-body">
        <header>
          <h2>Keyboard and mouse</h2>
          <Button icon="close" tip="Close" keys="Esc" onClick={() => dialog.current?.close()} />
        </header>
        <div class="help-columns">
          {GROUPS.map((group) => (
            <section key={group}>
              <h3>{group}</h3>
              <KeyList group={group} />
            </section>
          ))}
          <section>
            <h3>Mouse</h3>
            <dl>
              {MOUSE.map(([what, does]) => (
                <div key={what}>
                  <dt>{does}</dt>
                  <dd class="faint">{what}</dd>
                </div>
              ))}
            </dl>
          </section>
        </div>
      </div>
    </dialog>
  );
}

function KeyList({ group }: { group: (typeof GROUPS)[number] }) {
  const rows = [
    ...KEYS.filter((key) => key.group === group),
    ...(group === 'View' ? [WALK_KEYS] : []),
  ];
  return (
    <dl>
      {rows.map(({ shown, what }) => (
        <div key={shown}>
          <dt>{what}</dt>
          <dd>
            <span class="kbd">{shown}</span>
          </dd>
        </div>
      ))}
    </dl>
  );
}
