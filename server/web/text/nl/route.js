// Dutch: the keys of en/route.js.

export default {
  "route.intro":
    "Hoe de aandrijving naar chaos leidt: de hoek één keer in elke periode van de aandrijving, na haar eerste 80 perioden, tegen de sterkte van de aandrijving. Eén punt is een slingering met de aandrijving mee, twee zijn er een met de dubbele periode, een wolk is chaos.",
  "route.from": "Sterkte van",
  "route.to": "Sterkte tot",
  "route.strength": "sterkte van de aandrijving, {unit}",
  "route.plot": "Hoek één keer in elke periode van de aandrijving, tegen haar sterkte",
  "route.hint":
    "Klik op een sterkte: de slinger wordt ermee aangedreven. De schuiven hierboven doen hetzelfde.",
  "route.none":
    "Niets drijft deze slinger heen en weer: geef hem een motor of schud zijn draaipunt.",
};
