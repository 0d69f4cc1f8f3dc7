// Spanish: what the examples show, and their groups.

export default {
  "examples.first": "Primeros pasos",
  "examples.surprising": "Sorprendente",
  "examples.driven": "Forzamiento y rozamiento",
  "examples.trees": "Árboles y cadenas",
  "examples.more": "Otros",
  "preset.single.words":
    "Un brazo, soltado a 40°. Su periodo es de 2,07 s, un 3 % más largo que según la fórmula de las oscilaciones pequeñas.",
  "preset.side-by-side.words":
    "Dos péndulos que no se tocan. Uno es cuatro veces más largo que el otro, así que su periodo es el doble. Cambia una longitud o una masa y compara.",
  "preset.double.words":
    "Dos brazos iguales en una oscilación pequeña: un modo lento y uno rápido a la vez.",
  "preset.upright.words":
    "Soltado a 5° de la vertical superior: se demora arriba, y su periodo es mucho más largo que el de una oscilación pequeña.",
  "preset.kapitza.words":
    "El pivote se agita arriba y abajo 32 veces por segundo: así el péndulo se mantiene cabeza abajo. Con una amplitud de menos de 11 mm se cae.",
  "preset.coupled.words":
    "Dos péndulos iguales cuelgan de un marco que un muelle mantiene derecho. El primero cede su oscilación al segundo, y la recupera.",
  "preset.two-to-one.words":
    "Con 0,64 kg y 0,36 kg un modo es exactamente el doble de rápido que el otro: los extremos vuelven tras cada periodo lento.",
  "preset.chaotic-double.words":
    "Soltado desde encima de la horizontal. Dos inicios casi iguales se separan en segundos: Comparar lo muestra.",
  "preset.double-bars.words":
    "Dos barras sin nada en los extremos, como la mayoría de los péndulos dobles de mesa.",
  "preset.driven-damped.words":
    "Un motor lo gira a un lado y a otro, el rozamiento lo frena. Con un motor de 0,9 N m oscila al compás del motor, con 1,07 N m necesita dos periodos para repetirse, y con 1,15 N m, como aquí, no se repite nunca: el camino al caos.",
  "preset.laboratory-double.words":
    "Un banco de pruebas con cojinetes y un motor en la segunda articulación, descrito por quince números.",
  "preset.metronome-cart.words":
    "El brazo de un metrónomo, con su pesa arriba y otra más pesada abajo, sobre un carrito que rueda: brazo y carrito oscilan uno contra otro, un poco más deprisa que sobre una mesa.",
  "preset.bar-on-stop.words": "Cada choque le deja el 80 % de la velocidad, hasta que reposa.",
  "preset.clock.words": "Un motor lo empuja en el punto más bajo si oscila menos de 12°.",
  "preset.paper-four-arms.words":
    "El ejemplo del artículo: dos brazos cuelgan de la segunda articulación. Se suelta en reposo desde la horizontal.",
  "preset.triple.words": "Tres brazos iguales, uno debajo de otro, soltados desde la horizontal.",
  "preset.non-standard-triple.words":
    "Dos brazos cuelgan del extremo del primero. En un modo oscilan uno contra otro y el primer brazo no se mueve: este inicio se le acerca.",
  "preset.chain-10.words":
    "Diez brazos iguales, soltados rectos y horizontales. El tirón recorre la cadena hasta su extremo, que da un latigazo.",
  "preset.star.words":
    "Ocho brazos alrededor de un extremo, abiertos como radios. Solo actúan unos sobre otros a través del centro.",
  "preset.binary-4.words": "Cada brazo lleva dos más cortos y ligeros, en cuatro niveles.",
  "preset.whip.words":
    "Dieciséis brazos cada vez más ligeros hacia la punta. Una sacudida del extremo pesado corre hacia fuera, y la punta da un latigazo.",
  "preset.thor.words":
    "Un tronco ligero con dos brazos pesados que giran en sentidos opuestos y zarandean la articulación.",
  "preset.octopus.words": "Cuatro tentáculos de cuatro brazos cada uno, en una cabeza pesada.",
  "preset.mobile.words":
    "Brazos de longitud y masa muy distintas: una oscilación lenta y pesada con otras rápidas y ligeras encima.",
};
