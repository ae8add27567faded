import { ICONS, type IconName } from './icons';

/** One icon of the set; it takes the text's colour and is hidden from screen readers. */
export function Icon({ name }: { name: IconName }) {
  return (
    <svg class="icon" viewBox="0 0 16 16" aria-hidden="true" data-icon={name}>
      <path d={ICONS[name]} />
    </svg>
  );
}
