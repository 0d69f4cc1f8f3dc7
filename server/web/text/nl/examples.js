// Dutch: what the examples show, and their groups.

export default {
  "examples.first": "Eerste stappen",
  "examples.surprising": "Verrassend",
  "examples.driven": "Aandrijving en wrijving",
  "examples.trees": "Bomen en kettingen",
  "examples.more": "Meer",
  "preset.single.words":
    "Eén arm, losgelaten bij 40°. De periode is 2,07 s, 3 % langer dan volgens de formule voor kleine uitwijkingen.",
  "preset.side-by-side.words":
    "Twee slingers die elkaar niet raken. De ene is vier keer zo lang als de andere, dus is zijn periode twee keer zo lang. Verander een lengte of een massa en vergelijk.",
  "preset.double.words":
    "Twee gelijke armen met kleine uitwijking: een langzame en een snelle eigentrilling tegelijk.",
  "preset.upright.words":
    "Losgelaten op 5° van rechtop: hij blijft even bovenaan hangen, en zijn periode is veel langer dan die van een kleine slingering.",
  "preset.kapitza.words":
    "Het ophangpunt schudt 32 keer per seconde op en neer: zo blijft de slinger ondersteboven staan. Met een amplitude onder 11 mm valt hij.",
  "preset.coupled.words":
    "Twee gelijke slingers hangen aan een frame dat een veer rechtop houdt. De eerste geeft zijn slingering door aan de tweede en krijgt haar terug.",
  "preset.two-to-one.words":
    "Met 0,64 kg en 0,36 kg is de ene eigentrilling precies twee keer zo snel als de andere: de uiteinden keren na elke langzame periode terug.",
  "preset.chaotic-double.words":
    "Losgelaten boven de horizontale stand. Twee bijna gelijke starts gaan binnen seconden uit elkaar: Vergelijken laat het zien.",
  "preset.double-bars.words":
    "Twee staven met niets aan de uiteinden, zoals de meeste dubbele slingers op een tafel.",
  "preset.driven-damped.words":
    "Een motor draait hem heen en weer, wrijving remt hem. Met een motor van 0,9 N m slingert hij in de maat van de motor, met 1,07 N m herhaalt hij zich pas na twee perioden, en met 1,15 N m, zoals hier, herhaalt hij zich nooit: de weg naar chaos.",
  "preset.laboratory-double.words":
    "Een proefopstelling met lagers en een motor in het tweede scharnier, beschreven door vijftien getallen.",
  "preset.metronome-cart.words":
    "De arm van een metronoom, met zijn gewicht boven en een zwaarder onder, op een wagentje dat rolt: arm en wagentje slingeren tegen elkaar in, iets sneller dan op een tafel.",
  "preset.bar-on-stop.words": "Elke botsing laat 80 % van de snelheid over, tot hij ligt.",
  "preset.clock.words": "Een motor duwt hem in het laagste punt, zolang hij onder 12° blijft.",
  "preset.paper-four-arms.words":
    "Het voorbeeld van het artikel: twee armen hangen aan het tweede scharnier. In rust losgelaten vanuit de horizontale stand.",
  "preset.triple.words": "Drie gelijke armen onder elkaar, losgelaten vanuit de horizontale stand.",
  "preset.non-standard-triple.words":
    "Twee armen hangen aan het uiteinde van de eerste. In één eigentrilling slingeren ze tegen elkaar in en staat de eerste arm stil: deze start ligt daar dichtbij.",
  "preset.chain-10.words":
    "Tien gelijke armen, gestrekt en horizontaal losgelaten. De trek loopt langs de ketting naar het uiteinde, dat doorslaat.",
  "preset.star.words":
    "Acht armen rond één uiteinde, gespreid als spaken. Ze werken alleen via de naaf op elkaar.",
  "preset.binary-4.words": "Elke arm draagt twee kortere en lichtere, vier niveaus diep.",
  "preset.whip.words":
    "Zestien armen die naar het uiteinde toe lichter worden. Een ruk aan het zware eind loopt naar buiten, en de punt zwiept.",
  "preset.thor.words":
    "Een lichte stam met twee zware armen die in tegengestelde richting draaien en het scharnier heen en weer gooien.",
  "preset.octopus.words": "Vier tentakels van elk vier armen, aan een zware kop.",
  "preset.mobile.words":
    "Armen van heel verschillende lengte en massa: een langzame zware slingering met snelle lichte erbovenop.",
};
