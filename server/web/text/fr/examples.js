// French: what the examples show, and their groups.

export default {
  "examples.first": "Premiers pas",
  "examples.surprising": "Surprenant",
  "examples.driven": "Forçage et frottement",
  "examples.trees": "Arbres et chaînes",
  "examples.more": "Autres",
  "preset.single.words":
    "Un bras, lâché à 40°. Sa période est de 2,07 s, 3 % de plus que selon la formule des petites oscillations.",
  "preset.side-by-side.words":
    "Deux pendules qui ne se touchent pas. L’un est quatre fois plus long que l’autre, sa période est donc deux fois plus longue. Changez une longueur ou une masse et comparez.",
  "preset.double.words":
    "Deux bras égaux en petites oscillations : un mode lent et un mode rapide en même temps.",
  "preset.upright.words":
    "Lâché à 5° de la verticale haute : il s’attarde en haut, et sa période est bien plus longue que celle d’une petite oscillation.",
  "preset.kapitza.words":
    "Le pivot tremble de haut en bas 32 fois par seconde : le pendule se tient alors la tête en bas. Avec une amplitude sous 11 mm, il tombe.",
  "preset.coupled.words":
    "Deux pendules égaux sont accrochés à un cadre qu’un ressort tient debout. Le premier cède son oscillation au second, puis la récupère.",
  "preset.two-to-one.words":
    "Avec 0,64 kg et 0,36 kg, un mode est exactement deux fois plus rapide que l’autre : les bouts reviennent après chaque période lente.",
  "preset.chaotic-double.words":
    "Lâché au-dessus de l’horizontale. Deux départs presque identiques se séparent en quelques secondes : Comparer le montre.",
  "preset.double-bars.words":
    "Deux barres sans masse aux extrémités, comme la plupart des pendules doubles posés sur une table.",
  "preset.driven-damped.words":
    "Un moteur le tourne dans un sens puis dans l’autre, le frottement le freine. Avec un moteur de 0,9 N m il oscille au rythme du moteur, avec 1,07 N m il lui faut deux périodes pour se répéter, et avec 1,15 N m, comme ici, il ne se répète jamais : la route vers le chaos.",
  "preset.laboratory-double.words":
    "Un banc d’essai avec des paliers et un moteur dans la deuxième articulation, décrit par quinze nombres.",
  "preset.metronome-cart.words":
    "Le bras d’un métronome, avec son poids en haut et un autre, plus lourd, en bas, sur un chariot qui roule : bras et chariot oscillent l’un contre l’autre, un peu plus vite que sur une table.",
  "preset.bar-on-stop.words": "Chaque choc lui laisse 80 % de sa vitesse, puis elle repose.",
  "preset.clock.words": "Un moteur la pousse au point le plus bas, en dessous de 12°.",
  "preset.paper-four-arms.words":
    "L’exemple de l’article : deux bras sont attachés à la deuxième articulation. Lâché sans vitesse depuis l’horizontale.",
  "preset.triple.words": "Trois bras égaux, l’un sous l’autre, lâchés depuis l’horizontale.",
  "preset.non-standard-triple.words":
    "Deux bras sont attachés au bout du premier. Dans un mode, ils oscillent l’un contre l’autre et le premier bras reste immobile : ce départ en est proche.",
  "preset.chain-10.words":
    "Dix bras égaux, lâchés tendus et horizontaux. La traction court le long de la chaîne jusqu’à son bout, qui claque.",
  "preset.star.words":
    "Huit bras autour d’un bout, écartés comme des rayons. Ils n’agissent les uns sur les autres que par le moyeu.",
  "preset.binary-4.words":
    "Chaque bras en porte deux plus courts et plus légers, sur quatre niveaux.",
  "preset.whip.words":
    "Seize bras de plus en plus légers vers le bout. Un coup donné au bout lourd court vers l’extérieur, et la pointe fouette.",
  "preset.thor.words":
    "Un tronc léger avec deux bras lourds qui tournent en sens opposés et secouent l’articulation.",
  "preset.octopus.words": "Quatre tentacules de quatre bras chacun, sur une tête lourde.",
  "preset.mobile.words":
    "Des bras de longueurs et de masses très différentes : une oscillation lente et lourde, avec de rapides et légères par-dessus.",
};
