/** Something that opens beside a button: menus, the tracking form, the colour picker. */
import { signal, type Signal } from '@preact/signals';
import { type ComponentChildren, createContext, type RefObject } from 'preact';
import { createPortal } from 'preact/compat';
import { useContext, useEffect, useLayoutEffect, useRef } from 'preact/hooks';
import { Button } from './controls';
import { Icon, type IconName } from '../../common/icons';

const MARGIN = 8;

/** Closes the popover that a part is in. */
const Closing = createContext(() => {});

interface PopoverProps {
  anchor: RefObject<HTMLElement | null>;
  label: string;
  onClose: () => void;
  class?: string;
  children: ComponentChildren;
}

export function Popover({ anchor, label, onClose, class: extra = '', children }: PopoverProps) {
  const box = useRef<HTMLDivElement>(null);
  useLayoutEffect(() => {
    if (!box.current || !anchor.current) return;
    place(box.current, anchor.current);
    const focusable = box.current.querySelector<HTMLElement>(
      '[data-autofocus], button, input, select',
    );
    (focusable ?? box.current).focus({ preventScroll: true });
    const opener = anchor.current;
    const opened = box.current;
    return () => {
      const { activeElement } = document;
      if (activeElement === document.body || opened.contains(activeElement))
        opener.focus({ preventScroll: true });
    };
  }, [anchor]);
  useEffect(() => {
    const outside = (event: PointerEvent): void => {
      const target = event.target as Node;
      if (!box.current?.contains(target) && !anchor.current?.contains(target)) onClose();
    };
    // The focused control may have been removed, and the focus with it.
    const unfocused = (event: KeyboardEvent): void => {
      if (event.key !== 'Escape' || document.activeElement !== document.body) return;
      event.stopPropagation();
      onClose();
    };
    document.addEventListener('pointerdown', outside, true);
    document.addEventListener('keydown', unfocused, true);
    return () => {
      document.removeEventListener('pointerdown', outside, true);
      document.removeEventListener('keydown', unfocused, true);
    };
  }, [anchor, onClose]);
  return createPortal(
    <div
      ref={box}
      class={`popover ${extra}`}
      role="dialog"
      aria-label={label}
      tabIndex={-1}
      onKeyDown={(event) => keys(event, box.current!, onClose)}
    >
      <Closing.Provider value={onClose}>{children}</Closing.Provider>
    </div>,
    document.getElementById('dialogs')!,
  );
}

interface MenuItemProps {
  icon?: IconName;
  label: string;
  tip?: string;
  disabled?: boolean;
  /** The menu stays open. */
  stays?: boolean;
  /** After the label: keys, or a count. */
  children?: ComponentChildren;
  onClick: () => void;
}

/** A line of a menu. */
export function MenuItem({ icon, label, tip, disabled, stays, children, onClick }: MenuItemProps) {
  const close = useContext(Closing);
  const choose = (): void => {
    if (!stays) close();
    onClick();
  };
  return (
    <button type="button" class="menu-item" data-tip={tip} disabled={disabled} onClick={choose}>
      {icon && <Icon name={icon} />} {label}
      {children}
    </button>
  );
}

interface PopoverButtonProps {
  open: Signal<boolean>;
  icon?: IconName;
  tip: string;
  keys?: string;
  kind?: 'outlined' | 'primary';
  pressed?: boolean;
  small?: boolean;
  disabled?: boolean;
  /** Text of the button, and its class. */
  button?: { label: string; class?: string };
  /** Name of the popover. */
  label: string;
  class?: string;
  children: ComponentChildren;
}

/** A button and its popover. */
export function PopoverButton({
  open,
  label,
  class: extra,
  button,
  children,
  ...look
}: PopoverButtonProps) {
  const anchor = useRef<HTMLButtonElement>(null);
  return (
    <>
      <Button
        {...look}
        {...button}
        buttonRef={anchor}
        expanded={open.value}
        onClick={() => (open.value = !open.value)}
      />
      {open.value && (
        <Popover
          anchor={anchor}
          label={label}
          onClose={() => (open.value = false)}
          {...(extra === undefined ? {} : { class: extra })}
        >
          {children}
        </Popover>
      )}
    </>
  );
}

/** Below the anchor, or above it where there is more room; inside the window. */
function place(box: HTMLElement, anchor: HTMLElement): void {
  const at = anchor.getBoundingClientRect();
  const { offsetWidth: width, offsetHeight: height } = box;
  const below = at.bottom + 4;
  const top =
    below + height + MARGIN <= innerHeight ? below : Math.max(MARGIN, at.top - 4 - height);
  const left = Math.max(MARGIN, Math.min(at.left, innerWidth - width - MARGIN));
  box.style.top = `${top}px`;
  box.style.left = `${left}px`;
}

function keys(event: KeyboardEvent, box: HTMLElement, close: () => void): void {
  if (event.key === 'Escape') {
    event.preventDefault();
    event.stopPropagation();
    close();
    return;
  }
  const target = event.target as HTMLElement;
  const step = event.key === 'ArrowDown' ? 1 : event.key === 'ArrowUp' ? -1 : 0;
  if (step === 0 || !target.classList.contains('menu-item')) return;
  event.preventDefault();
  const items = [...box.querySelectorAll<HTMLElement>('.menu-item')];
  items[(items.indexOf(target) + step + items.length) % items.length]?.focus();
}

/** Popovers that more than one place opens. */
export const helpOpen = signal(false);
export const commandsOpen = signal(false);
export const exportOpen = signal(false);
