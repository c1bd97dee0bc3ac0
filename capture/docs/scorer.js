/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What the search of the handbook finds, and in which order. Sphinx puts this into language_data.js.
   Sphinx finds a heading only by its exact words. Here, two thirds of the words find it, in any order. */

const ofPages = Search.performTermsSearch;
Search.performTermsSearch = (wanted, excluded) => [...ofPages(wanted, excluded), ...headings(wanted)];

function headings(wanted) {
  const { alltitles, titles, docnames, filenames } = Search._index;
  const stemmer = new Stemmer();
  return Object.entries(alltitles).flatMap(([title, places]) => {
    const words = splitQuery(title.toLowerCase()).map((word) => stemmer.stemWord(word));
    const found = [...wanted].filter((word) => words.includes(word)).length;
    if (!found || 3 * found < 2 * wanted.size) return [];
    const score = 20 * (found / wanted.size) + found / words.length; // a page has 15 at most
    return places.map(([file, id]) => {
      const name = titles[file] === title ? title : `${titles[file]} > ${title}`;
      return [docnames[file], name, id ? `#${id}` : "", null, score, filenames[file], SearchResultKind.title];
    });
  });
}

// Of equals, first what helps at a machine; last what only somebody needs who changes sistap.
const LAST = /CHANGELOG|CONTRIBUTING|SECURITY|DEVELOP|FILES|benchmark|drivers|launcher|windows\/README|tests|fuzz/;
Scorer.score = ([page, , , , score]) => score + 2 * /troubleshooting/.test(page) - 10 * LAST.test(page);
