/** First things first: points are on their way while most of the page has still to load. */
import './style/index.css';
import { Early } from './net/early';

const early = new Early();
void import('./page').then(({ startPage }) => startPage(early));
